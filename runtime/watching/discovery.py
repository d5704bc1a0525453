"""How a tool finds the robot that is meant: by name, by file, or as the only one that runs."""

import argparse
import json
import random
import socket
import struct
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import NamedTuple

from plant.errors import MsmaError
from runtime.errors import RunError
from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.mesh import (
    ALL_BASES,
    LOOPBACK,
    SLOTS,
    Address,
    Endpoints,
    Mesh,
    on_loopback,
    port_base,
)
from runtime.wire.messages import Diag, unpack
from runtime.wire.refusals import MessageError
from runtime.wire.security import OPERATOR, Credentials

_LOOKED_AT = 8  # ports of each robot: of plant, goal and the first agents
_FIRST_PORTS = [base + slot for base in ALL_BASES for slot in range(_LOOKED_AT)]
_ALL_PORTS = range(ALL_BASES.start, ALL_BASES.stop)
_TABLES = {"/proc/net/tcp": socket.AF_INET, "/proc/net/tcp6": socket.AF_INET6}
_LISTENS = "0A"  # as those tables say it
_PATIENCE = 1.0  # [s]
_NONE_CONNECTS = 3.0  # [s] until none of those that listen is expected to accept a tool any more
_FEW_CONNECT = 1.0  # [s] the same for the others, once one has
_CHECKING = 0.1  # [s] for all others to check a certificate, once one has
_BY_FILE = "if its file sets its port, hosts or security, give the file: --file FILE"


class Target(NamedTuple):
    """A robot to visit: its name, where its processes are, and what to show them."""

    robot: str
    mesh: Mesh
    credentials: Credentials | None = None


def target_of(args: argparse.Namespace) -> Target:
    """Return the robot that the command line means; `RunError` if there is not one to choose."""
    if args.file is not None:
        from runtime.config.deployment import load  # most of what a tool imports, if it does
        from runtime.config.overrides import Override

        name = [Override("--robot", "robot", json.dumps(args.robot))] if args.robot else []
        deployment = load(args.file, name, topics.PLANT)
        return Target(deployment.robot, deployment.mesh, deployment.credentials(OPERATOR))
    if args.robot is not None:
        if _places(args.robot) <= {LOOPBACK}:
            return _at_home(args.robot)
        return _by_its_file(args.robot, robots_here())
    running = robots_here()
    if len(running) == 1:
        robot = next(iter(running))
        if _places(robot) == {LOOPBACK}:
            return _at_home(robot)
        return _by_its_file(robot, running)
    if running:
        raise RunError(f"several robots run here: {', '.join(running)}; say which: --robot NAME")
    raise RunError(f"no robot runs here; {_BY_FILE}")


def robots_here() -> dict[str, str]:
    """Return the names of the robots that run on this machine, and a deployment file of each.

    A port that is taken among those of any robot is asked whose it is. A robot whose deployment
    file sets its port is not found so, nor one that speaks to those it knows only.
    """
    dials = tuple(there for there in _listening() if there.port in _ALL_PORTS)
    if not dials:
        return {}
    with Bus(None, "a tool", Endpoints(Address(LOOPBACK, 0), dials), random.getrandbits(63)) as bus:
        answers = bus.ask(f"*/{topics.EVERY_DIAG}", timeout=_PATIENCE)
    found = {}
    for answer in answers:
        with suppress(MessageError):
            diag = unpack(Diag, answer.data)
            if diag.host == socket.gethostname():
                found[answer.key.partition("/")[0]] = diag.deployment
    return dict(sorted(found.items()))


def _by_its_file(robot: str, running: Mapping[str, str]) -> Target:
    """Return a robot that runs here, wherever else it is by the file it was started with."""
    from runtime.config.deployment import load

    with suppress(MsmaError):
        deployment = load(running.get(robot, ""), only_role=topics.PLANT)
        if deployment.robot == robot:
            return Target(robot, deployment.mesh, deployment.credentials(OPERATOR))
    return _at_home(robot)


def _at_home(robot: str) -> Target:
    return Target(robot, on_loopback(port_base(robot)))


def _places(robot: str) -> set[str]:
    """Return at which addresses of this machine something listens at a robot's usual ports."""
    base = port_base(robot)
    return {there.host for there in _listening() if base <= there.port < base + SLOTS}


def _listening() -> list[Address]:
    """Return where something listens for TCP at an address of this machine, among our ports."""
    found = []
    for file, family in _TABLES.items():
        try:
            lines = Path(file).read_text().splitlines()[1:]
        except OSError:  # not Linux: at the usual address only
            return [Address(LOOPBACK, port) for port in _FIRST_PORTS if is_taken(port)]
        for local, state in ((line.split()[1], line.split()[3]) for line in lines):
            if state == _LISTENS:
                address, _, port = local.partition(":")
                words = struct.unpack(f"!{len(address) // 8}I", bytes.fromhex(address))
                host = socket.inet_ntop(family, struct.pack(f"={len(words)}I", *words))
                found.append(Address(host, int(port, 16)))
    return found


def is_taken(port: int, host: str = LOOPBACK) -> bool:
    """Tell whether somebody listens on a port of this machine, at one of its addresses."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError:
            return True
    return False


def _somebody(bus: Bus, target: Target) -> bool:
    """Tell whether anybody is there, once all had time to connect.

    On the same machine they usually have when a session is open, but not if it is busy or if they
    check certificates. A process that hangs does not connect.
    """
    began = time.monotonic()
    while not (there := bool(bus.who_is_alive(_PATIENCE))) or bus.links < _processes(target):
        if time.monotonic() > began + (_FEW_CONNECT if there else _NONE_CONNECTS):
            break
        if target.mesh.addresses == (LOOPBACK,) and not _processes(target):
            break
        time.sleep(0.02)
    if target.credentials is not None:
        time.sleep(_CHECKING)
    return there


def _processes(target: Target) -> int:
    """Return how many of the places that a tool dials are taken, on this machine."""
    return len(set(_listening()).intersection(target.mesh.visitor().dials))


@contextmanager
def visit(target: Target) -> Iterator[Bus]:
    """Join the bus of a running robot as a tool; `RunError` if nothing runs there."""
    mesh = target.mesh
    incarnation = random.getrandbits(63)
    with Bus(target.robot, "a tool", mesh.visitor(), incarnation, target.credentials) as bus:
        if not _somebody(bus, target):
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
        help="its deployment file; needed if it sets port, hosts or security",
    )
