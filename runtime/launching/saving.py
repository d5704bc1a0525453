"""Results are shown even where they cannot be kept: a full disk loses no more than its files."""

from collections.abc import Callable
from contextlib import suppress
from pathlib import Path


def save(file: Path, write: Callable[[Path], object]) -> str:
    """Let `write` write a file; return in a line why it could not, or nothing.

    No half of a file is left.
    """
    try:
        write(file)
    except OSError as error:
        with suppress(OSError):
            file.unlink(missing_ok=True)
        return f"  {file} cannot be written: {error.strerror or error}"
    return ""
