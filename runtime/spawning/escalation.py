"""How a group of processes is made to end: it is asked to, then SIGTERM, then SIGKILL."""

import time
from collections.abc import Callable
from signal import SIGKILL, SIGTERM

from plant.errors import MsmaError
from runtime.spawning.local import ProcessExit, ProcessGroup

_TURN = 0.02  # [s] between two looks at the processes


def end_all(
    processes: ProcessGroup,
    *,
    after: float = 0.0,
    pause: float = 0.6,
    ask: Callable[[], object] | None = None,
    ended: Callable[[ProcessExit], None] = lambda one: None,
) -> None:
    """Go from step to step until no process is left.

    A step that fails does not keep the next one from being tried.

    Args:
        processes: What is to end.
        after: How long they have to end by themselves [s].
        pause: How long to wait after each step [s].
        ask: Asks all processes to stop; by default they get signals only.
        ended: Is called with each process that has ended.

    Raises:
        Exception: The first error of a step, once no process is left, unless it is one that
            systems and networks cause (`MsmaError`, `OSError`).
    """
    steps: list[Callable[[], object]] = [] if ask is None else [ask]
    steps += [lambda: processes.signal(SIGTERM), lambda: processes.signal(SIGKILL)]
    due = time.monotonic() + after
    failed: Exception | None = None
    while processes:
        if steps and time.monotonic() >= due:
            due += pause
            try:
                steps.pop(0)()
            except (MsmaError, OSError):
                pass  # the next step will do
            except Exception as error:
                failed = failed or error
        for one in processes.ended():
            ended(one)
        time.sleep(_TURN)
    if failed is not None:
        raise failed
