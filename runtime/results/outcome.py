"""How a run went, as its launcher saw it."""

import json
from pathlib import Path
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
        page: The address of the page from which a person drives the robot; empty without one.
    """

    code: int
    reason: str
    view: View
    events: tuple[RunEvent, ...]
    host: str | None = None
    page: str = ""


def page_of(run: Path) -> str:
    """Return the address that the page of a run has left in its folder; empty if there is none."""
    try:
        page = json.loads((run / "page.json").read_text(encoding="utf-8"))["page"]
    except (OSError, ValueError, LookupError, TypeError):
        return ""
    return page if isinstance(page, str) and page.isprintable() else ""
