"""The log of one process: JSON lines in files of bounded size, written by a thread of its own."""

import json
import os
import stat
import sys
import threading
import time
from collections import deque
from contextlib import suppress
from itertools import count
from pathlib import Path
from typing import Any

from plant.errors import MsmaError
from runtime.wire.topics import file_name

TICK = b'"event": "tick"'
"""What a line of the robot's motion has and no other."""
DROPPED = "dropped"
"""The event that stands where older lines of motion were dropped."""
LOG_MEGABYTES = 512
"""What the log of one process may take by default [MB]: 20 minutes of a plant at 1 kHz."""
_PARTS = 8  # files at most that have it together: the oldest eighth goes for a new one
_PAUSE = 0.5  # [s] between two writes
_PATIENCE = 1.0  # [s] that anybody waits for the disk
_MOST_WAITING = 100_000  # lines that wait for a disk that hangs


def numbered_parts(log: Path) -> dict[int, Path]:
    """Return the older files of a log, ROLE.0.jsonl, ROLE.1.jsonl and so on, the oldest first."""
    parts = ((part.name.split(".")[-2], part) for part in log.parent.glob(f"{log.stem}.*.jsonl"))
    return dict(sorted((int(number), part) for number, part in parts if number.isdigit()))


class LogError(MsmaError, OSError):
    """A log that cannot be written; the message names the file and says why."""

    def __init__(self, path: Path, error: OSError) -> None:
        why = error.strerror or str(error)
        super().__init__(
            f"the log {path} cannot be written: {why}; `runs` of the deployment file, or "
            "`--run` of a single process, gives another folder"
        )


class LogWriter:
    """Appends lines to ROLE.jsonl; a revived process continues the file.

    Every line has `wall` (seconds since 1970), `t` (plant time, s) and `event`. No line waits for
    the disk. When the file has an eighth of the log's size it becomes ROLE.1.jsonl, ROLE.2.jsonl
    and so on. Of the oldest that is too many all but motion is kept in ROLE.0.jsonl.
    """

    def __init__(self, folder: Path, role: str, megabytes: float = LOG_MEGABYTES) -> None:
        self.path = folder / f"{file_name(role)}.jsonl"
        self._most = megabytes * 1e6 / _PARTS  # [bytes] of one file
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file = self._opened()
        except OSError as error:
            raise LogError(self.path, error) from None
        self._complained = False
        self._lines: deque[str] = deque()
        self._lost = 0
        self._flushes: deque[threading.Event] = deque()
        self._wake = threading.Event()
        self._closing = False
        self._thread: threading.Thread | None = None

    def write(self, t: float, event: str, **more: Any) -> None:
        """Note an event at plant time `t` [s]; with a `wall` if it was not just now."""
        self.line(_line(t, event, **more))

    def line(self, line: str) -> None:
        """Note a line that is JSON already."""
        if self._closing:
            return
        if len(self._lines) < _MOST_WAITING:
            self._lines.append(line)
        else:
            self._lost += 1
        if self._thread is None:  # not before: a process with a thread cannot be forked
            self._thread = threading.Thread(target=self._run, name="log", daemon=True)
            self._thread.start()

    def flush(self, patience: float = _PATIENCE) -> bool:
        """Have written what was noted; wait up to `patience` [s], and return whether it is."""
        if self._thread is None:
            return True
        written = threading.Event()
        self._flushes.append(written)
        self._wake.set()
        return written.wait(patience)

    def close(self) -> None:
        """Write the rest and close the file; do not wait for a disk that hangs."""
        self._closing = True
        self._wake.set()
        if self._thread is None:
            os.close(self._file)
        else:
            self._thread.join(_PATIENCE)

    def _run(self) -> None:
        while not self._closing or self._lines:
            self._wake.wait(_PAUSE)
            self._wake.clear()
            flushes = [self._flushes.popleft() for _ in range(len(self._flushes))]
            self._write([self._lines.popleft() for _ in range(len(self._lines))])
            for written in flushes:
                written.set()
        os.close(self._file)

    def _write(self, lines: list[str]) -> None:
        """Write lines; say once that this fails: a full disk stops nobody."""
        if self._lost:
            lines.append(_line(0.0, "lost", lines=self._lost, why="the disk hung"))
            self._lost = 0
        try:
            if lines:
                self._append("".join(f"{line}\n" for line in lines).encode())
        except OSError as error:
            if not self._complained:
                print(LogError(self.path, error), file=sys.stderr)
            self._complained = True

    def _append(self, data: bytes) -> None:
        with suppress(FileNotFoundError):
            if not os.path.samestat(os.stat(self.path), os.fstat(self._file)):  # by a copy
                self._reopen()
        while data:
            data = data[os.write(self._file, data) :]
        now = os.fstat(self._file)
        if now.st_size >= self._most and stat.S_ISREG(now.st_mode):
            self._rotate()

    def _opened(self) -> int:
        return os.open(self.path, os.O_WRONLY | os.O_CREAT | os.O_APPEND, 0o644)

    def _reopen(self) -> None:
        before, self._file = self._file, self._opened()
        os.close(before)

    def _rotate(self) -> None:
        """Begin a new file, and drop the oldest of them that are too many."""
        parts = numbered_parts(self.path)
        rest = parts.pop(0, self.path.with_suffix(".0.jsonl"))
        full = self.path.with_suffix(f".{max(parts, default=0) + 1}.jsonl")
        self.path.rename(full)
        self._reopen()
        older = [*parts.values(), full]
        while older[1:] and sum(part.stat().st_size for part in older) > (_PARTS - 1) * self._most:
            old = older.pop(0)
            with old.open("rb") as whole, rest.open("ab") as kept:
                kept.writelines(line for line in whole if TICK not in line)
                why = f"it would take more than {self._most * _PARTS / 1e6:g} MB"
                kept.write(f"{_line(0.0, DROPPED, why=why)}\n".encode())
            old.unlink()


def _line(t: float, event: str, **more: Any) -> str:
    return json.dumps({"wall": round(time.time(), 6), "t": t, "event": event, **more})


def new_run_folder(runs: Path, robot: str) -> Path:
    """Make a folder for a new run of a robot, named by the time of day, and return it."""
    name = f"{robot}-{time.strftime('%Y%m%d-%H%M%S')}"
    folder = runs / name
    for number in count(2):
        try:
            folder.mkdir(parents=True)
            break
        except FileExistsError:
            folder = runs / f"{name}-{number}"
        except OSError as error:
            raise LogError(folder, error) from None
    return folder
