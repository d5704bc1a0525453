"""Files that others find whole or not at all, also if this process dies or the disk is full."""

import os
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path


def write_atomically(file: Path, write: Callable[[Path], object]) -> None:
    """Let `write` write a file beside `file`, whose place that then takes.

    Args:
        file: To be written.
        write: Writes the file that it is given, the name of which ends as that of `file`.

    Raises:
        OSError: It cannot be written; nothing is left of it, and what was there before still is.
    """
    new = file.with_name(f".{os.getpid()}.{file.name}")
    try:
        write(new)
        new.replace(file)
    except OSError:
        with suppress(OSError):
            new.unlink(missing_ok=True)
        raise
