"""How a tool finds the robot that is meant: by name, by file, or as the only one that runs.

A run that this user started on this machine is in the registry, with all that the tool needs.
Others are asked for on the ports of this machine, and nothing is known of their files.
"""

import argparse
import json
import random
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from runtime.errors import RunError
from runtime.spawning.ports import block_of, listens, robots_at
from runtime.spawning.registry import runs_of, why_not
from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.mesh import ALL_BASES, LOOPBACK, Mesh, on_loopback, port_base
from runtime.wire.security import OPERATOR, Credentials

if TYPE_CHECKING:
    from runtime.config.deployment import Deployment  # most of what a tool imports, if it does

_ANSWER = 1.0  # [s]
_NONE_CONNECTS = 10.0  # [s] until none of those that listen is expected to accept a tool any more
_FEW_CONNECT = 1.0  # [s] the same for the others, once one has
_CHECKING = 0.1  # [s] for all others to check a certificate, once one has
_BY_FILE = "if another user or host has started it, give its file: --file FILE"


class Target(NamedTuple):
    """A robot to visit.

    Attributes:
        credentials: What to show its processes, where certificates are asked for.
        runs: The folders of its runs on this machine that this user has started, or has named.
    """

    robot: str
    mesh: Mesh
    credentials: Credentials | None = None
    runs: tuple[Path, ...] = ()

    def run_with(self, role: str) -> Path:
        """Return the folder of the run that has the role; `RunError` if none can be trusted."""
        if not self.runs:
            raise RunError(
                f"{why_not(self.robot)}: if you trust the files of the run, name its deployment: "
                f"--file RUN/deployment.yaml"
            )
        log = f"{topics.file_name(role)}.jsonl"
        return next((run for run in self.runs if (run / log).exists()), self.runs[0])


def target_of(args: argparse.Namespace) -> Target:
    """Return the robot that the command line means; `RunError` if there is not one to choose."""
    file = Path(args.file or "")  # which the user trusts
    deployment = None if args.file is None else _load(file, args.robot)
    robot: str = deployment.robot if deployment else args.robot or _only_robot()
    known = runs_of(robot)
    runs = {run.folder: run.port for run in known}
    if deployment is None and known and not known[0].plain:
        deployment = _load(known[0].deployment)
    elif deployment and file.name == "deployment.yaml" and any(file.parent.glob("*.jsonl")):
        runs = {file.parent.absolute(): deployment.port}
    if deployment is None or (deployment.has_usual_ports and deployment.port not in runs.values()):
        port = known[0].port if known else block_of(robot, port_base(robot))
        mesh = deployment.mesh._replace(base=port) if deployment else on_loopback(port)
    else:
        mesh = deployment.mesh
    folders = tuple(run for run, port in runs.items() if port == mesh.base)
    credentials = deployment.credentials(OPERATOR) if deployment else None
    return Target(robot, mesh, credentials, folders)


def _only_robot() -> str:
    names = robots_here()
    if len(names) > 1:
        raise RunError(f"several robots run here: {', '.join(names)}; say which: --robot NAME")
    if not names:
        raise RunError(f"no robot runs here; {_BY_FILE}")
    return names[0]


def _load(file: Path, robot: str | None = None) -> "Deployment":
    from runtime.config.deployment import load
    from runtime.config.overrides import Override

    name = [Override("--robot", "robot", json.dumps(robot))] if robot else []
    return load(file, name, topics.PLANT)


def robots_here() -> list[str]:
    """Return the names of the robots that run on this machine.

    Those of other users are not found if they have a port, hosts or certificates of their own.
    """
    return sorted({run.robot for run in runs_of()} | robots_at(*ALL_BASES))


def anything_connects(bus: Bus, target: Target) -> bool:
    """Tell whether any process is there, once all had time to connect.

    On the same machine they usually have when a session is open, but not if it is busy or if they
    check certificates. A process that hangs does not connect.
    """
    began = time.monotonic()
    while True:
        there = bool(bus.who_is_alive(_ANSWER))
        listening = sum(listens(*one) for one in target.mesh.visitor().dials)  # on this machine
        none_here = not listening and target.mesh.addresses == (LOOPBACK,)
        timeout = _FEW_CONNECT if there else _NONE_CONNECTS
        if (there and bus.links >= listening) or none_here or time.monotonic() > began + timeout:
            break
        time.sleep(0.02)
    if target.credentials is not None:
        time.sleep(_CHECKING)
    return there


def join(target: Target) -> Bus:
    """Join the bus of a robot as a tool, and do not wait for its processes to connect."""
    place, incarnation = target.mesh.visitor(), random.getrandbits(63)
    return Bus(target.robot, "a tool", place, incarnation, target.credentials)


@contextmanager
def visit(target: Target) -> Iterator[Bus]:
    """Join the bus of a running robot as a tool; `RunError` if nothing runs there."""
    with join(target) as bus:
        if not anything_connects(bus, target):
            mesh = target.mesh
            where = f"ports {mesh.base} and up of {', '.join(mesh.addresses)}"
            hint = "" if target.credentials else f"; {_BY_FILE}"
            raise RunError(f"nothing of robot {target.robot} runs ({where}){hint}")
        yield bus


def add_target_options(parser: argparse.ArgumentParser, **arguments: str) -> None:
    """Add positional arguments, by their names and help, and options that name a running robot."""
    for name, text in arguments.items():
        parser.add_argument(name, metavar=name.upper(), help=text)
    group = parser.add_argument_group("robot", "By default the only one running on this machine.")
    group.add_argument("--robot", metavar="NAME", help="its name on the network")
    group.add_argument(
        "--file",
        metavar="FILE",
        help="its deployment file; needed if another user or host has started it with a port, "
        "hosts or security of its own",
    )
