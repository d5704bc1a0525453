"""Open the page by which a person drives a robot, and start the robot if it does not run.

It prints the page's address with its token, on a line that begins with `page:`. A robot that runs
and has no page gets one from here, until Ctrl-C; a file without one is started with one, at rest.
"""

import argparse
import json
import sys
import time
from functools import partial
from pathlib import Path
from threading import Thread
from typing import Any

from nodes.hmi.address import FILE, Address, find_address
from nodes.hmi.page import Page
from plant.robot import Robot
from runtime.config.deployment import Deployment, load
from runtime.config.options import load_from
from runtime.config.overrides import Override
from runtime.config.tree import ConfigError
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
_NODE = {"role": PAGE, "class": "nodes.hmi.page:Page"}
_REACH = {
    "listen": ("ADDRESS", "address that the page listens at, so that others reach it"),
    "certificate": ("FILE", "its TLS certificate (PEM), which --listen needs"),
    "key": ("FILE", "the certificate's private key (PEM)"),
    "name": ("NAME", "another name or address by which browsers call this computer"),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of `msma launch`, and who can reach a page that is made from here."""
    launch.add_arguments(parser)
    group = parser.add_argument_group("page", "By default only this computer reaches it.")
    for name, (metavar, text) in _REACH.items():
        how = "append" if name == "name" else "store"
        group.add_argument(f"--{name}", metavar=metavar, help=text, action=how)


def run(args: argparse.Namespace) -> int:
    """Print where the page of a running robot is, serve one for it, or start the robot with one."""
    deployment = load_from(args, only_role=PLANT)
    reach = _reach_of(args)
    running = runs_of(deployment.robot)
    if running:
        folder = running[0].folder
        there = load(folder / "deployment.yaml", only_role=PLANT)
        address = find_address(folder)
        if there.has_page and address is not None:
            _refuse_if(reach, "it runs with a page")
            _say(address)
            return 0
        return _serve(there, folder, reach)
    if deployment.has_page:
        _refuse_if(reach, "its file has a page")
    else:
        more = [Override("msma web", "nodes.+", json.dumps(_NODE | reach))]
        if deployment.duration is not None and "duration" not in _overridden(args):
            more.append(Override("msma web", "duration", "null"))  # until Ctrl-C
        args.overrides = [*(args.overrides or []), *(partial(Override, *one) for one in more)]
    return launch.run(args)


def _overridden(args: argparse.Namespace) -> set[str]:
    """Return the paths of what the command line sets."""
    return {make().path for make in args.overrides or ()}


def _reach_of(args: argparse.Namespace) -> dict[str, Any]:
    """Return the parameters of the page that the command line sets."""
    given = {name: getattr(args, name) for name in _REACH if getattr(args, name) is not None}
    if names := given.pop("name", None):
        given["names"] = names
    for name in {"certificate", "key"} & given.keys():
        given[name] = str(Path(given[name]).absolute())
    return given


def _refuse_if(reach: dict[str, Any], why: str) -> None:
    if reach:
        what = ", ".join(f"--{name.removesuffix('s')}" for name in reach)
        raise ConfigError(f"{what}: is for a robot without a page, and {why}: set it there")


class _Visitor(Context):
    """What the page needs where it is no process of the run, but a tool that visits it."""

    def __init__(self, deployment: Deployment, run: Path, bus: Bus) -> None:
        self.role, self.run, self.bus = PAGE, run, bus
        self.deployment = deployment
        self.ending = Shutdown()
        self.log = LogWriter(run, PAGE)
        self.refusals = Refusals()
        self.t = 0.0
        self._clock = BusClock(bus, time.monotonic())

    @property
    def robot(self) -> Robot:
        return self.deployment.description.robot

    def watch(self) -> None:
        """Wait for a reason to end: a signal, or the end of the run."""
        while not self.ending.wait(_CHECK):
            now = time.monotonic()
            try:
                self.t = self._clock.look(now)
            except BusError as error:
                self.ending.ask(str(error), FAILED)
            if end := self._clock.end(self.deployment, now):
                self.ending.ask(*end)


def _serve(deployment: Deployment, folder: Path, reach: dict[str, Any]) -> int:
    """Serve a page for a robot that runs without one, until Ctrl-C or its end."""
    if deployment.security is not None:
        raise RunError(
            f"{deployment.robot} runs without a page, and its certificates let no other process "
            f"drive it: add a node to its file, {json.dumps(_NODE)}, and start it again"
        )
    paths = {name: Path(reach[name]) for name in ("certificate", "key") if name in reach}
    page = Page(**(reach | paths | {"names": tuple(reach.get("names", ()))}))
    target = Target(deployment.robot, deployment.mesh, None, (folder,))
    with visit(target) as bus:
        visitor = _Visitor(deployment, folder, bus)
        visitor.ending.catch_signals()
        watching = Thread(target=visitor.watch)
        watching.start()
        serving = Thread(target=_announce, args=(visitor,), daemon=True)
        serving.start()
        try:
            page.run(visitor)
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
