"""Show what a URDF or xacro file offers, and a deployment to start from."""

import argparse
from pathlib import Path

from plant import packages, proposal, urdf
from plant.drawing import draw


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `msma robot`."""
    parser.add_argument("file", metavar="FILE", help="URDF or xacro file, or a robot of ours")
    parser.add_argument("--package", help="the installed package that has FILE")
    parser.add_argument("--tip", metavar="LINK", help="end the arm here")
    parser.add_argument("--plot", metavar="PNG", type=Path, help="draw the arm into this image")


def run(args: argparse.Namespace) -> int:
    """Print the robot's joints, tips and deployment, and return the exit code."""
    path = packages.find(args.package, args.file) if args.package else args.file
    found = proposal.propose(urdf.read(path), args.tip)
    for line in _columns(proposal.report(found)):
        print(f"# {line}".rstrip())
    if args.plot is not None:
        draw(found.robot, proposal.posture(found.robot), args.plot)
        print(f"# drawn in {args.plot}")
    named = args.package or not Path(args.file).suffix
    print()
    print(
        proposal.deployment(
            found, args.file if named else str(Path(args.file).absolute()), args.package
        ),
        end="",
    )
    return 0


def _columns(rows: list[tuple[str, ...]]) -> list[str]:
    """Return the rows of each table with their cells below each other."""
    lines: list[str] = []
    table: list[tuple[str, ...]] = []
    for row in [*rows, ()]:
        if row:
            table.append(row)
            continue
        count = max(map(len, table), default=0)
        widths = [max(len(r[i]) for r in table if i < len(r)) for i in range(count)]
        lines += ["  ".join(c.ljust(w) for c, w in zip(r, widths, strict=False)) for r in table]
        lines.append("")
        table = []
    return lines[:-1]
