"""The table of processes as text, for terminals, pipes and summaries alike."""

import math
import os
import sys
from collections.abc import Sequence

from runtime.watching.roster import Row
from runtime.watching.watcher import View
from runtime.wire.messages import Spread

HEADINGS = ("role", "pid", "host", "alive", "loop Hz", "answer ms", "refused", "state")
"""`answer ms` is median and 99th percentile of the latency of answers to the plant."""


def cells(row: Row, now: float) -> tuple[str, ...]:
    """Return a process's line, under the headings; `now` [s] is on the watcher's clock."""
    alive = "yes" if row.alive else f"gone {_ago(now - row.since)}"
    if row.diag is None:
        return (row.role, "", "", alive, "", "", "", "")
    diag = row.diag
    state = diag.state if diag.state != "runs" or diag.perception == "none" else diag.perception
    rate = f"{diag.rate:.4g}" if row.alive else ""
    answer = "" if row.answer is None else milliseconds(row.answer)
    seen = (alive, rate, answer, str(row.refused), state if row.alive else "")
    return (row.role, str(diag.pid), diag.host, *seen)


def milliseconds(spread: Spread, *, worst: bool = False) -> str:
    """Return median and 99 %, and the worst if wanted, in ms."""
    return "/".join(f"{1e3 * value:.3g}" for value in spread[: 3 if worst else 2])


def _ago(seconds: float) -> str:
    if seconds < 100:
        return f"{max(seconds, 0.0):.0f} s"
    return f"{seconds / 60:.0f} min" if seconds < 6000 else f"{seconds / 3600:.0f} h"


def columns(lines: Sequence[Sequence[str]]) -> list[str]:
    """Return lines of cells as aligned text."""
    widths = [max(map(len, column)) for column in zip(*lines, strict=True)]
    return [
        "  ".join(cell.ljust(width) for cell, width in zip(line, widths, strict=True)).rstrip()
        for line in lines
    ]


def distance(metres: float | None) -> str:
    """Return a distance as people write it; `-` if it is not known."""
    if metres is None:
        return "-"
    return f"{1e3 * metres:.2f} mm" if abs(metres) < 0.1 else f"{metres:.3f} m"


def who_moves(view: View) -> str:
    """Return what to add to a line about a robot that its agents do not move by themselves."""
    return "" if view.gate is None or view.gate.mode == "automatic" else f", {view.gate.text}"


def off(metres: float | None, radians: float = 0.0) -> str:
    """Return how far a hand is off: its distance, and its angle unless that is 0."""
    return distance(metres) + (f" and {math.degrees(radians):.2f} deg" if radians else "")


def say(text: str) -> None:
    """Print a text at once; into nothing once the reader of a pipe has gone."""
    try:
        print(text, flush=True)
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
