"""What the verbs `study` and `bench` have in common: which to run, and where to write."""

import argparse
from collections.abc import Callable, Collection
from pathlib import Path

from rich.console import Console

from plant.errors import MsmaError


def add_arguments(
    parser: argparse.ArgumentParser, known: Collection[str], *, folder: str, scaled: str
) -> None:
    """Add the name, one of those `known` or all, and where to write.

    folder: to write to if none is given; scaled: what `--size` is a share of
    """
    parser.add_argument("name", help=f"which: {', '.join(known)}, or all")
    parser.add_argument(
        "--out", type=Path, default=Path(folder), help=f"folder to write to ({folder})"
    )
    parser.add_argument(
        "--size", type=float, default=1.0, help=f"share of the {scaled}, for a quick look (1)"
    )
    parser.add_argument(
        "--no-pictures", action="store_true", help="tables only; needs no matplotlib"
    )


def prepare(
    args: argparse.Namespace, known: Collection[str], find: Callable[[str], object],
    error: type[MsmaError],
) -> list[str]:  # fmt: skip
    """Return the names asked for, when all can be run, with the folder to write to made.

    find: raises for a name that is not known; error: of the verb, raised for all else
    """
    if not 0 < args.size <= 1:
        raise error(f"--size {args.size:g}: must be above 0 and at most 1")
    names = list(known) if args.name == "all" else [args.name]
    for name in names:
        find(name)  # so that a wrong name is told before anything is run
    if not args.no_pictures:
        try:
            import matplotlib  # noqa: F401  # only whether it is there
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
    """Return what to print tables on: as wide as the terminal, or wide where there is none."""
    there = Console()
    return there if there.is_terminal else Console(width=160)
