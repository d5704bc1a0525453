"""Open the page by which a person drives a robot, and start the robot if it does not run.

It prints the page's address with its token, on a line that begins with `page:`. A robot that runs
and has no page gets one from here, until Ctrl-C; a file without one is started with one, at rest.
"""

import argparse
import sys
import time
from functools import partial
from pathlib import Path
from threading import Thread

from nodes.hmi.address import FILE, Address, find_address
from nodes.hmi.page import Page
from plant.robot import Robot
from runtime.config.deployment import Deployment, load
from runtime.config.options import load_from
from runtime.config.overrides import Override
from runtime.errors import RunError
from runtime.processes.lifetime import FAILED, Shutdown
from runtime.processes.log_writer import LogWriter
from runtime.processes.node import Context
from runtime.processes.plant_clock import BusClock
from runtime.spawning.registry import runs_of
from runtime.verbs import launch
from runtime.watching.discovery import Target, visit
from runtime.watching.table import say
from runtime.wire.bus import Bus, BusError
from runtime.wire.refusals import Refusals
from runtime.wire.topics import PAGE, PLANT

_CHECK = 0.1  # [s]
_NODE = f"{{role: {PAGE}, class: nodes.hmi.page:Page}}"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `msma launch`."""
    launch.add_arguments(parser)


def run(args: argparse.Namespace) -> int:
    """Print where the page of a running robot is, serve one for it, or start the robot with one."""
    deployment = load_from(args, only_role=PLANT)
    running = runs_of(deployment.robot)
    if running:
        folder = running[0].folder
        there = load(folder / "deployment.yaml", only_role=PLANT)
        address = find_address(folder)
        if there.has_page and address is not None:
            _say(address)
            return 0
        return _serve(there, folder)
    if not deployment.has_page:
        more = [Override("msma web", "nodes.+", _NODE)]
        if deployment.duration is not None and "duration" not in _overridden(args):
            more.append(Override("msma web", "duration", "null"))  # until Ctrl-C
        args.overrides = [*(args.overrides or []), *(partial(Override, *one) for one in more)]
    return launch.run(args)


def _overridden(args: argparse.Namespace) -> set[str]:
    """Return the paths of what the command line sets."""
    return {make().path for make in args.overrides or ()}


class _Visitor(Context):
    """What the page needs where it is no process of the run, but a tool that visits it."""

    def __init__(self, deployment: Deployment, run: Path, bus: Bus) -> None:
        self.role, self.run, self.bus = PAGE, run, bus
        self._deployment = deployment
        self.ending = Shutdown()
        self.log = LogWriter(run, PAGE)
        self.refusals = Refusals()
        self.t = 0.0
        self._clock = BusClock(bus, time.monotonic())

    @property
    def robot(self) -> Robot:
        return self._deployment.description.robot

    def watch(self) -> None:
        """Wait for a reason to end: a signal, or the end of the run."""
        while not self.ending.wait(_CHECK):
            now = time.monotonic()
            try:
                self.t = self._clock.look(now)
            except BusError as error:
                self.ending.ask(str(error), FAILED)
            if end := self._clock.end(self._deployment, now):
                self.ending.ask(*end)


def _serve(deployment: Deployment, folder: Path) -> int:
    """Serve a page for a robot that runs without one, until Ctrl-C or its end."""
    if deployment.security is not None:
        raise RunError(
            f"{deployment.robot} runs without a page, and its certificates let no other process "
            f"drive it: add a node to its file, {_NODE}, and start it again"
        )
    target = Target(deployment.robot, deployment.mesh, None, (folder,))
    with visit(target) as bus:
        visitor = _Visitor(deployment, folder, bus)
        visitor.ending.catch_signals()
        watching = Thread(target=visitor.watch)
        watching.start()
        serving = Thread(target=_announce, args=(visitor,), daemon=True)
        serving.start()
        try:
            Page().run(visitor)
        finally:
            visitor.ending.ask("the page ended", FAILED)
            watching.join()
            visitor.log.close()
            (folder / FILE).unlink(missing_ok=True)
    print(visitor.ending.reason, file=sys.stderr)
    return visitor.ending.code


def _announce(visitor: _Visitor) -> None:
    """Print the addresses as soon as the page is served."""
    while visitor.ending.reason is None:
        if address := find_address(visitor.run):
            _say(address)
            return
        time.sleep(_CHECK)


def _say(address: Address) -> None:
    say(f"page: {address.page}\npage for engineers: {address.engineers_page}")
