"""How a run went, as its launcher saw it."""

from typing import NamedTuple

from runtime.watching.watcher import View


class RunEvent(NamedTuple):
    """Something that happened at plant time `t` [s]."""

    t: float
    text: str


class RunOutcome(NamedTuple):
    """How a run went.

    Attributes:
        code: 130 if it was interrupted, else 0.
        view: The last view of the processes while they were alive.
        events: What only the launcher logs: how processes ended, and what failed.
        host: The host whose processes alone were started; None if all were.
    """

    code: int
    reason: str
    view: View
    events: tuple[RunEvent, ...]
    host: str | None = None
