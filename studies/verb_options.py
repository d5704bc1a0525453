"""Options shared by the verbs `study` and `bench`: what to run, and where to write."""

import argparse
from collections.abc import Callable, Collection
from pathlib import Path

from rich.console import Console

from plant.errors import MsmaError


def add_arguments(
    parser: argparse.ArgumentParser, known: Collection[str], *, folder: str, scaled: str
) -> None:
    """Add the name, the output folder, the size and whether to draw.

    Args:
        parser: The parser of the verb.
        known: The valid names, besides `all`.
        folder: Default of the output folder.
        scaled: What `--size` is a share of.
    """
    parser.add_argument("name", help=f"one of {', '.join(known)}, or all")
    parser.add_argument("--out", type=Path, default=Path(folder), help=f"output folder ({folder})")
    parser.add_argument(
        "--size", type=float, default=1.0, help=f"share of the {scaled}, for a quick look (1)"
    )
    parser.add_argument(
        "--no-pictures", action="store_true", help="write tables only; does not need matplotlib"
    )


def prepare(
    args: argparse.Namespace, known: Collection[str], find: Callable[[str], object],
    error: type[MsmaError],
) -> list[str]:  # fmt: skip
    """Check the options, make the output folder, and return the names to run.

    Args:
        args: The parsed command line.
        known: The valid names, besides `all`.
        find: Raises for an unknown name.
        error: The exception to raise for anything else.
    """
    if not 0 < args.size <= 1:
        raise error(f"--size {args.size:g}: must be above 0 and at most 1")
    names = list(known) if args.name == "all" else [args.name]
    for name in names:
        find(name)  # so that an unknown name is reported before anything runs
    if not args.no_pictures:
        try:
            import matplotlib  # noqa: F401  # only to see whether it is installed
        except ModuleNotFoundError:
            raise error(
                "pictures need matplotlib: pip install 'msma[plots]', or give --no-pictures"
            ) from None
    try:
        args.out.mkdir(parents=True, exist_ok=True)
    except OSError as failed:
        raise error(f"--out {args.out}: {failed.strerror or failed}") from failed
    return names


def console() -> Console:
    """Return a console as wide as the terminal, or 160 columns wide without a terminal."""
    there = Console()
    return there if there.is_terminal else Console(width=160)
