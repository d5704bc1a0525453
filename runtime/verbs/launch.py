"""Start the processes of a robot, stay with them to the end of the run, and say how it went."""

import argparse
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from runtime.config.deployment import Deployment
from runtime.config.options import add_deployment_options, load_from
from runtime.launching.launcher import Launcher, prepare
from runtime.watching.table import say

if TYPE_CHECKING:
    from pathlib import Path

    from runtime.launching.launcher import RunOutcome
    from runtime.watching.screen import Screen


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the file, its overrides, and which hosts' processes to start how."""
    add_deployment_options(parser)
    group = parser.add_argument_group("which hosts", "by default all is started on this one")
    which = group.add_mutually_exclusive_group()
    which.add_argument("--host", metavar="NAME", help="start this host's share only")
    which.add_argument("--ssh", action="store_true", help="start each host's share by ssh")
    which.add_argument(
        "--rehearse",
        action="store_true",
        help="make the hosts on this machine, on a network that chaos can break; takes root",
    )


def run(args: argparse.Namespace) -> int:
    """Launch; 0 if the hand ends within tolerance of the goal, 3 if it does not."""
    deployment = load_from(args)
    if args.rehearse:
        return _rehearse(deployment)
    if args.ssh:
        return _by_ssh(deployment)
    if args.host is not None:
        deployment.check_share(args.host)
    folder = prepare(deployment, host=args.host)
    course = Launcher(deployment, folder, _screen_of(deployment), host=args.host).go()
    return _close(deployment, folder, course, [] if args.host is None else ["--host", args.host])


def _rehearse(deployment: Deployment) -> int:
    from runtime.rehearsal.virtual_network import VirtualNetwork
    from runtime.spawning.remote import RemoteProcesses

    with VirtualNetwork(deployment) as network:
        deployment = network.deployment
        folder = prepare(deployment, network)
        network.build(folder)
        processes = RemoteProcesses(folder, network.hosts, away=False)
        course = Launcher(deployment, folder, _screen_of(deployment), network, processes).go()
    return _close(deployment, folder, course, ["--rehearse"])


def _by_ssh(deployment: Deployment) -> int:
    from runtime.spawning.remote import RemoteProcesses
    from runtime.spawning.ssh import connect

    folder = prepare(deployment)
    with connect(deployment, folder) as hosts:
        processes = RemoteProcesses(folder, hosts, away=True)
        course = Launcher(deployment, folder, _screen_of(deployment), processes=processes).go()
    return _close(deployment, folder, course, ["--ssh"])


def _screen_of(deployment: Deployment) -> "Callable[[], Screen]":
    def make_screen() -> "Screen":
        from runtime.watching.screen import open_screen

        return open_screen(deployment.duration)

    return make_screen


def _close(
    deployment: Deployment, folder: "Path", course: "RunOutcome", again: Sequence[str]
) -> int:
    from runtime.results.finishing import close

    summary, picture = close(deployment, folder, course, again)
    say(f"{summary.text()}\n{picture}".rstrip())
    return summary.code
