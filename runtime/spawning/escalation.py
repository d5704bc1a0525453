"""How a group of processes is made to end: first asked, then by signals, each step once."""

import time
from collections.abc import Callable, Iterable
from enum import Enum
from signal import Signals

from plant.errors import MsmaError
from runtime.spawning.local import ProcessExit, ProcessGroup

_TURN = 0.02  # [s] between two looks at the processes


class Means(Enum):
    """How a process is made to end, in the order in which it is tried."""

    ASK = "stop"
    TERMINATE = "SIGTERM"
    KILL = "SIGKILL"


ALL_MEANS = tuple(Means)
FORCE = (Means.TERMINATE, Means.KILL)


class Escalation:
    """The steps from asking to killing, each due once, some time after the one before.

    Args:
        began: When the end was wanted [s], on the clock that `due` is given.
        means: The steps.
        pause: How long to wait after each [s].
    """

    def __init__(
        self, began: float, means: Iterable[Means] = ALL_MEANS, pause: float = 0.6
    ) -> None:
        self._left = [(began + index * pause, each) for index, each in enumerate(means)]

    def due(self, now: float) -> list[Means]:
        """Return the steps that have become due at `now` [s]."""
        due = [means for at, means in self._left if at <= now]
        self._left = self._left[len(due) :]
        return due


def end_all(
    processes: ProcessGroup,
    escalation: Escalation,
    *,
    ask: Callable[[], object] = lambda: None,
    ended: Callable[[ProcessExit], None] = lambda one: None,
) -> None:
    """Go through the steps until no process is left.

    A step that fails does not keep the next one from being tried.

    Args:
        processes: What is to end.
        escalation: The steps.
        ask: Asks all processes to stop.
        ended: Is called with each process that has ended.

    Raises:
        Exception: The first error of a step, once no process is left, unless it is one that
            systems and networks cause (`MsmaError`, `OSError`).
    """
    failed: Exception | None = None
    while processes:
        for means in escalation.due(time.monotonic()):
            try:
                if means is Means.ASK:
                    ask()
                else:
                    processes.signal(Signals[means.value])
            except (MsmaError, OSError):
                continue  # the next step will do
            except Exception as error:
                failed = failed or error
        for one in processes.ended():
            ended(one)
        time.sleep(_TURN)
    if failed is not None:
        raise failed
