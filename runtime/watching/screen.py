"""What people see of a run while it goes on: a live table on a terminal, plain lines elsewhere."""

import time

from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Column, Table
from rich.text import Text

from runtime.watching.table import HEADINGS, cells, distance, say, who_moves
from runtime.watching.watcher import View

_LINE = 1.0  # [s] between two plain lines


class Screen:
    """Shows people a run of a `duration` [s], if it has one: a line a second and for each event."""

    def __init__(self, duration: float | None) -> None:
        self._duration = duration
        self._next = 0.0

    def happened(self, t: float, text: str) -> None:
        """Show what happened at plant time `t` [s]."""
        self.line(_event(t, text))

    def line(self, text: str) -> None:
        """Show a line that is not to vanish."""
        say(text)

    def show(self, view: View) -> None:
        """Print the view, unless the last line was printed just before."""
        now = time.monotonic()
        if now >= self._next:
            self._next = now + _LINE
            there = sum(row.alive for row in view.rows)
            say(f"{_progress(view, self._duration)}  {there} processes alive")

    def close(self) -> None:
        """Leave the terminal as it was."""


class LiveTable(Screen):
    """A progress bar and a table that stay in place; what happens scrolls by above them."""

    def __init__(self, duration: float | None) -> None:
        super().__init__(duration)
        self._console = Console(highlight=False)
        self._live = Live(console=self._console, auto_refresh=False, transient=True)
        self._live.start()

    def happened(self, t: float, text: str) -> None:
        self._console.print(Text(_event(t, text), style="bold yellow"))

    def line(self, text: str) -> None:
        self._console.print(Text(text, style="bold"), soft_wrap=True)

    def show(self, view: View) -> None:
        self._live.update(picture(view, self._duration), refresh=True)

    def close(self) -> None:
        self._live.stop()


def picture(view: View, duration: float | None) -> RenderableType:
    """Return the bar over the run and the table of processes."""
    now = time.monotonic()
    table = Table(box=None, padding=(0, 2, 0, 0), header_style="dim", pad_edge=False)
    for index, heading in enumerate(HEADINGS):
        right = index in (1, 4, 5, 6)
        table.add_column(heading, justify="right" if right else "left", no_wrap=True)
    for row in view.rows:
        style = "yellow" if row.refused else ""
        table.add_row(*cells(row, now), style=style if row.alive else "red")
    line = Text(_progress(view, duration))
    if duration is None:
        return Group(line, table)
    head = Table.grid(Column(no_wrap=True), Column(ratio=1), padding=(0, 2, 0, 0), expand=True)
    head.add_row(line, ProgressBar(total=duration, completed=min(view.t, duration)))
    return Group(head, table)


def _progress(view: View, duration: float | None) -> str:
    of = "" if duration is None else f" of {duration:g}"
    error, worst = distance(view.error), distance(view.worst)
    return f"{view.t:6.2f}{of} s  hand {error} off, worst {worst}{who_moves(view)}"


def _event(t: float, text: str) -> str:
    return f"{t:6.2f} s  {text}"
