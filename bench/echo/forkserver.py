"""Starts modules as copies of one process that has imported them, as a launch does.

All copies have the same code at the same addresses, so the caches and branch predictors of the
processor serve all of them. Started one by one, each process has its own addresses, and a tick of
nine processes takes a quarter more processor time.

It reads commands as JSON, `[[module, argument, ...], ...]`, prints their process ids, gives its
standard output to the first one, and kills all of them when its standard input is closed.
"""

import gc
import json
import os
import signal
import sys
from collections.abc import Sequence
from functools import partial
from importlib import import_module

from runtime.processes.roles import preload
from runtime.processes.scheduling import set_realtime
from runtime.spawning.forkserver import copied

STARTED = "started"
"""The event that is printed first, with the `pids`."""


def main() -> None:
    """Start the commands on standard input, and kill their processes when it is closed."""
    commands: list[list[str]] = json.loads(sys.stdin.readline())
    preload()
    for name, *_ in commands:
        import_module(name)
    gc.freeze()  # so that garbage collection does not unshare the copies' memory
    pids = [
        copied(partial(_run_module, command, index == 0)) for index, command in enumerate(commands)
    ]
    print(json.dumps({"event": STARTED, "pids": pids}), flush=True)
    sys.stdin.read()
    for pid in pids:
        os.kill(pid, signal.SIGKILL)


def _run_module(command: Sequence[str], first: bool) -> int:
    """Run the module's `main` in this process."""
    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 0)
    if not first:
        os.dup2(nothing, 1)
    set_realtime()  # as all processes that are compared
    sys.argv = list(command)
    return import_module(command[0]).main() or 0


if __name__ == "__main__":
    main()
