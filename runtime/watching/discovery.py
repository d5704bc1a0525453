"""How a tool finds the robot that is meant: by name, by file, or as the only one that runs.

A run that this user started on this machine is in the registry, with all that the tool needs. Any
other is asked for on the ports of this machine: then nothing is known of its files.
"""

import argparse
import json
import random
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from runtime.errors import RunError
from runtime.spawning.ports import blocks_from, listens, robots_at, taken_blocks
from runtime.spawning.registry import runs_of, why_not
from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.mesh import LOOPBACK, Mesh, on_loopback, port_base
from runtime.wire.security import OPERATOR, Credentials

_ANSWER = 1.0  # [s]
_NONE_CONNECTS = 3.0  # [s] until none of those that listen is expected to accept a tool any more
_FEW_CONNECT = 1.0  # [s] the same for the others, once one has
_CHECKING = 0.1  # [s] for all others to check a certificate, once one has
_BY_FILE = "if another user or host has started it, give its file: --file FILE"


class Target(NamedTuple):
    """A robot to visit.

    Attributes:
        robot: Its name.
        mesh: Where its processes are.
        credentials: What to show them, where certificates are asked for.
        runs: The folders of its runs on this machine that this user has started, or has named.
    """

    robot: str
    mesh: Mesh
    credentials: Credentials | None = None
    runs: tuple[Path, ...] = ()

    def run_with(self, role: str) -> Path:
        """Return the folder of the run that has the role, or may have it.

        Raises:
            RunError: No run is known that can be trusted.
        """
        if not self.runs:
            raise RunError(
                f"{why_not(self.robot)}: if you trust the files of the run, name its deployment: "
                f"--file RUN/deployment.yaml"
            )
        log = f"{topics.file_name(role)}.jsonl"
        return next((run for run in self.runs if (run / log).exists()), self.runs[0])


def target_of(args: argparse.Namespace) -> Target:
    """Return the robot that the command line means; `RunError` if there is not one to choose."""
    if args.file is not None:
        return _by_file(Path(args.file), args.robot)
    if args.robot is not None:
        return _by_name(args.robot)
    names = robots_here()
    if len(names) == 1:
        return _by_name(names[0])
    if names:
        raise RunError(f"several robots run here: {', '.join(names)}; say which: --robot NAME")
    raise RunError(f"no robot runs here; {_BY_FILE}")


def robots_here() -> list[str]:
    """Return the names of the robots that run on this machine.

    Those that another user has started with a port, hosts or certificates of their own are not
    found.
    """
    return sorted({run.robot for run in runs_of()} | robots_at(*taken_blocks()))


def _by_file(file: Path, robot: str | None) -> Target:
    """Return the robot of a file that the user names, and so trusts."""
    from runtime.config.deployment import load  # most of what a tool imports, if it does
    from runtime.config.overrides import Override

    name = [Override("--robot", "robot", json.dumps(robot))] if robot else []
    deployment = load(file, name, topics.PLANT)
    runs = {run.folder: run.port for run in runs_of(deployment.robot)}
    if file.name == "deployment.yaml" and any(file.parent.glob("*.jsonl")):
        runs = {file.parent.absolute(): deployment.port}
    elif deployment.has_usual_ports:
        found = {run: port for run, port in runs.items() if port == deployment.port} or runs
        port = next(iter(found.values())) if found else _port_of(deployment.robot)
        deployment = replace(deployment, port=port)
    folders = tuple(run for run, port in runs.items() if port == deployment.port)
    credentials = deployment.credentials(OPERATOR)
    return Target(deployment.robot, deployment.mesh, credentials, folders)


def _by_name(robot: str) -> Target:
    runs = runs_of(robot)
    if not runs:
        return Target(robot, on_loopback(_port_of(robot)))
    port = runs[0].port
    folders = tuple(run.folder for run in runs if run.port == port)
    if runs[0].plain:
        return Target(robot, on_loopback(port), None, folders)
    from runtime.config.deployment import load

    deployment = load(runs[0].deployment, only_role=topics.PLANT)
    return Target(robot, deployment.mesh, deployment.credentials(OPERATOR), folders)


def _port_of(robot: str) -> int:
    """Return the first port of a robot on this machine: its usual one, or where it answers."""
    usual = port_base(robot)
    taken = set(taken_blocks())
    for base in blocks_from(usual):
        if base in taken and (taken == {usual} or robot in robots_at(base)):
            return base
    return usual


def _anything_connects(bus: Bus, target: Target) -> bool:
    """Return whether any process is there, once all had time to connect.

    On the same machine they usually have when a session is open, but not if it is busy or if they
    check certificates. A process that hangs does not connect.
    """
    began = time.monotonic()
    while not (there := bool(bus.who_is_alive(_ANSWER))) or bus.links < _listening(target):
        if time.monotonic() > began + (_FEW_CONNECT if there else _NONE_CONNECTS):
            break
        if target.mesh.addresses == (LOOPBACK,) and not _listening(target):
            break
        time.sleep(0.02)
    if target.credentials is not None:
        time.sleep(_CHECKING)
    return there


def _listening(target: Target) -> int:
    """Return how many of the endpoints that a tool dials are in use, on this machine."""
    return sum(listens(*there) for there in target.mesh.visitor().dials)


@contextmanager
def visit(target: Target) -> Iterator[Bus]:
    """Join the bus of a running robot as a tool; `RunError` if nothing runs there."""
    mesh = target.mesh
    incarnation = random.getrandbits(63)
    with Bus(target.robot, "a tool", mesh.visitor(), incarnation, target.credentials) as bus:
        if not _anything_connects(bus, target):
            where = f"ports {mesh.base} and up of {', '.join(mesh.addresses)}"
            hint = "" if target.credentials else f"; {_BY_FILE}"
            raise RunError(f"nothing of robot {target.robot} runs ({where}){hint}")
        yield bus


def add_target_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that name a running robot."""
    group = parser.add_argument_group("robot", "By default the only one running on this machine.")
    group.add_argument("--robot", metavar="NAME", help="its name on the network")
    group.add_argument(
        "--file",
        metavar="FILE",
        help="its deployment file; needed if another user or host has started it with a port, "
        "hosts or security of its own",
    )
