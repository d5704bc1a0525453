"""Starts modules of ours as copies of one process that has imported them, as a launch does.

So all have the same at the same addresses, and what the processor has learned of one serves the
next. Started one by one, each has addresses of its own, and a tick of nine processes takes a
quarter more of the processors' time.

It reads commands as JSON, `[[module, word, ...], ...]`, says their process ids, gives its standard
output to the first, and kills them all when its standard input is closed, whoever closes it.
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

BORN = "born"
"""The event that is printed first, with the `pids`."""


def main() -> None:
    """Start what standard input says, and end it when that is closed."""
    commands: list[list[str]] = json.loads(sys.stdin.readline())
    preload()
    for name, *_ in commands:
        import_module(name)
    gc.freeze()  # so that collecting garbage does not make the copies' memory their own
    pids = [copied(partial(_be, command, index == 0)) for index, command in enumerate(commands)]
    print(json.dumps({"event": BORN, "pids": pids}), flush=True)
    sys.stdin.read()
    for pid in pids:
        os.kill(pid, signal.SIGKILL)


def _be(command: Sequence[str], first: bool) -> int:
    """Run the module's `main` in this process."""
    nothing = os.open(os.devnull, os.O_RDWR)
    os.dup2(nothing, 0)
    if not first:
        os.dup2(nothing, 1)
    set_realtime()  # all sides alike
    sys.argv = list(command)
    return import_module(command[0]).main() or 0


if __name__ == "__main__":
    main()
