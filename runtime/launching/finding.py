"""How a tool finds the robot that is meant: by name, by file, or as the only one that runs."""

import argparse
import json
import random
import socket
from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

from runtime.config.deployment import load
from runtime.config.overrides import Override
from runtime.launching.failures import RunError
from runtime.wire import keys
from runtime.wire.bus import Bus
from runtime.wire.mesh import LOOPBACK, Address, Mesh, Place, on_loopback
from runtime.wire.ports import ALL_BASES, port_base
from runtime.wire.security import OPERATOR, Credentials

_LOOKED_AT = 8  # ports of each robot: of plant, goal and the first agents
_PATIENCE = 1.0  # [s]
_BY_FILE = "if its file sets its port, hosts or security, give the file: --file FILE"


class Target(NamedTuple):
    """A robot to visit: its name, where its processes are, and what to show them."""

    robot: str
    mesh: Mesh
    credentials: Credentials | None = None


def add_target_options(parser: argparse.ArgumentParser) -> None:
    """Let the command say which robot is meant."""
    group = parser.add_argument_group(
        "which robot", "by default the only one that runs on this machine"
    )
    group.add_argument("--robot", metavar="NAME", help="its name on the network")
    group.add_argument(
        "--file",
        metavar="FILE",
        help="its deployment file; needed if that sets its port, hosts or security",
    )


def target_of(args: argparse.Namespace) -> Target:
    """Return the robot that the command line means; `RunError` if there is not one to choose."""
    if args.file is not None:
        name = [Override("--robot", "robot", json.dumps(args.robot))] if args.robot else []
        deployment = load(args.file, name, keys.PLANT)
        return Target(deployment.robot, deployment.mesh, deployment.credentials(OPERATOR))
    if args.robot is not None:
        return Target(args.robot, on_loopback(port_base(args.robot)))
    running = robots_here()
    if len(running) == 1:
        return Target(running[0], on_loopback(port_base(running[0])))
    if running:
        raise RunError(f"several robots run here: {', '.join(running)}; say which: --robot NAME")
    raise RunError(f"no robot runs here; {_BY_FILE}")


def robots_here() -> list[str]:
    """Return the names of the robots that run on this machine.

    A port that is taken among those of any robot's first roles is asked whose it is. A robot
    whose deployment file sets its port is not found so.
    """
    ports = [base + slot for base in ALL_BASES for slot in range(_LOOKED_AT)]
    taken = tuple(port for port in ports if is_taken(port))
    if not taken:
        return []
    place = Place(Address(LOOPBACK, 0), tuple(Address(LOOPBACK, port) for port in taken))
    with Bus(None, "a tool", place, random.getrandbits(63)) as bus:
        answers = bus.ask(f"*/{keys.EVERY_DIAG}", timeout=_PATIENCE)
    return sorted({answer.key.partition("/")[0] for answer in answers})


def is_taken(port: int, host: str = LOOPBACK) -> bool:
    """Tell whether somebody listens on a port of this machine, at one of its addresses."""
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError:
            return True
    return False


@contextmanager
def visit(target: Target) -> Iterator[Bus]:
    """Join the bus of a running robot as a tool; `RunError` if nothing runs there."""
    mesh = target.mesh
    incarnation = random.getrandbits(63)
    with Bus(target.robot, "a tool", mesh.visitor(), incarnation, target.credentials) as bus:
        if not bus.who_is_alive(_PATIENCE):
            where = f"ports {mesh.base} and up of {', '.join(mesh.addresses)}"
            hint = "" if target.credentials else f"; {_BY_FILE}"
            raise RunError(f"nothing of robot {target.robot} runs ({where}){hint}")
        yield bus
