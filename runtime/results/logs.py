"""What the processes of a run have logged, read line by line: a log may not fit into memory."""

import os
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any

import msgspec

from runtime.processes.log_writer import numbered_parts
from runtime.wire.topics import file_name

_decode = msgspec.json.Decoder().decode


def raw_lines(run: Path, role: str) -> Iterator[bytes]:
    """Yield the lines of a process's log as they were written, of all its files."""
    log = run / f"{file_name(role)}.jsonl"
    with ExitStack() as stack, suppress(FileNotFoundError):
        newest = stack.enter_context(log.open("rb"))  # first: the writer may rename it meanwhile
        files = []
        for part in numbered_parts(log).values():
            with suppress(FileNotFoundError):  # it has just been dropped
                files.append(stack.enter_context(part.open("rb")))
        same = os.fstat(newest.fileno())
        files = [one for one in files if not os.path.samestat(os.fstat(one.fileno()), same)]
        for stream in (*files, newest):
            yield from stream


def log_lines(run: Path, role: str, event: str | None = None) -> Iterator[dict[str, Any]]:
    """Yield the lines of a process's log, or those of one kind of event, which is quicker.

    A line cut short by a kill is left out.
    """
    wanted = b"" if event is None else f'"event": "{event}"'.encode()
    for line in raw_lines(run, role):
        if wanted in line:
            with suppress(msgspec.DecodeError, UnicodeDecodeError):
                yield _decode(line)


def read_log(run: Path, role: str, event: str | None = None) -> list[dict[str, Any]]:
    """Return the lines of a process's log: for events, which are few."""
    return list(log_lines(run, role, event))
