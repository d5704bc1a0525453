"""Show the state of a running robot and of each of its processes."""

import argparse
import json
import time
from collections.abc import Mapping

from msgspec.structs import asdict
from setproctitle import setproctitle

from runtime.watching.discovery import add_target_options, target_of, visit
from runtime.watching.local import silent_roles, watcher_title
from runtime.watching.table import HEADINGS, cells, columns, distance, who_moves
from runtime.watching.watcher import View, Watcher

_FRAME, _LEAST = 0.25, 0.01
"""Longest and shortest time between two frames [s]."""
_HAND = 0.3  # [s] to wait for the hand's position


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_target_options(parser)
    how = parser.add_mutually_exclusive_group()
    how.add_argument("--watch", action="store_true", help="update until Ctrl-C")
    how.add_argument("--json", action="store_true", help="print JSON, in SI units")


def run(args: argparse.Namespace) -> int:
    """Print the state once, or show it until Ctrl-C."""
    target = target_of(args)
    with visit(target) as bus:
        watcher = Watcher(bus)
        watcher.ask_all()
        if args.watch:
            setproctitle(watcher_title(target.robot))  # by which chaos finds it
            _watch(watcher)
        view = _glance(watcher)
        silent = silent_roles(bus, target)
    if args.json:
        print(_json(target.robot, view, silent))
    else:
        print(_text(target.robot, view, silent))
    return 0


def _glance(watcher: Watcher) -> View:
    """Return the view once hand and goal are known, or after a while without them."""
    until = time.monotonic() + _HAND
    view = watcher.look()
    while (view.error is None or not view.t) and time.monotonic() < until:
        time.sleep(0.02)
        view = watcher.look()
    return view


def _watch(watcher: Watcher) -> None:
    from rich.live import Live

    from runtime.watching.screen import picture

    with Live(auto_refresh=False) as live:
        while True:
            live.update(picture(watcher.look(), None), refresh=True)
            watcher.wait(_FRAME)
            time.sleep(_LEAST)


def _text(robot: str, view: View, silent: Mapping[str, str]) -> str:
    now = time.monotonic()
    lines = [f"{robot}: {view.t:.2f} s, hand {distance(view.error)} off{who_moves(view)}"]
    lines += columns([HEADINGS, *(cells(row, now) for row in view.rows)])
    lines += [f"{role}: {how}" for role, how in silent.items()]
    for row in view.rows:
        for key, reasons in (row.diag.refused if row.diag else {}).items():
            counts = ", ".join(f"{count} {reason}" for reason, count in reasons.items())
            lines.append(f"{row.role} refused on {key}: {counts}")
    return "\n".join(lines)


def _json(robot: str, view: View, silent: Mapping[str, str]) -> str:
    processes = []
    for row in view.rows:
        process = {"role": row.role, "alive": row.alive}
        process["answer"] = row.answer and row.answer._asdict()
        diag = {} if row.diag is None else asdict(row.diag)
        processes.append(process | {k: v for k, v in diag.items() if k not in ("work", "answers")})
    seen = {"t": view.t, "hand": view.hand, "goal": view.goal, "error": view.error}
    gate = None if view.gate is None else asdict(view.gate)
    plain = {"robot": robot, **seen, "gate": gate, "processes": processes, "silent": silent}
    return json.dumps(plain, indent=2)
