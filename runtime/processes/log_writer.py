"""The log of one process: a file of JSON lines, written in batches."""

import json
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


class LogError(MsmaError, OSError):
    """A log that cannot be written; the message names the file and says why."""


class LogWriter:
    """Appends lines to ROLE.jsonl; a revived process goes on in the file of the former.

    Every line has `wall` (seconds since 1970), `t` (plant time, s) and `event`. Nothing is
    written before `flush`, which the process's watchdog calls every half second.
    """

    def __init__(self, folder: Path, role: str) -> None:
        self.path = folder / f"{file_name(role)}.jsonl"
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._file = self.path.open("a", encoding="utf-8")
        except OSError as error:
            raise _unwritable(self.path, error) from None
        self._complained = False
        self._lines: deque[str] = deque()
        self._writing = threading.Lock()

    def write(self, t: float, event: str, **more: Any) -> None:
        """Note an event at plant time `t` [s]; with a `wall` if it was not just now."""
        self.line(json.dumps({"wall": round(time.time(), 6), "t": t, "event": event, **more}))

    def line(self, line: str) -> None:
        """Note a line that is JSON already."""
        self._lines.append(line)

    def flush(self) -> None:
        """Write what was noted. A disk that is full is complained of once: it stops nobody."""
        with self._writing:
            lines = [self._lines.popleft() for _ in range(len(self._lines))]
            if not lines or self._file.closed:
                return
            try:
                self._file.write("\n".join(lines) + "\n")
                self._file.flush()
            except OSError as error:
                if not self._complained:
                    print(_unwritable(self.path, error), file=sys.stderr)
                self._complained = True

    def close(self) -> None:
        """Write the rest and close the file."""
        self.flush()
        with self._writing, suppress(OSError):
            self._file.close()


def _unwritable(path: Path, error: OSError) -> LogError:
    why = error.strerror or str(error)
    return LogError(
        f"the log {path} cannot be written: {why}; `runs` of the deployment file, or "
        "`--run` of a single process, gives another folder"
    )


def new_run_folder(runs: Path, robot: str) -> Path:
    """Make a folder for a new run of a robot, named by the time of day, and return it."""
    name = f"{robot}-{time.strftime('%Y%m%d-%H%M%S')}"
    for number in count(1):
        folder = runs / (name if number == 1 else f"{name}-{number}")
        try:
            folder.mkdir(parents=True)
        except FileExistsError:
            continue
        except OSError as error:
            raise _unwritable(folder, error) from None
        return folder
    raise AssertionError("count never ends")
