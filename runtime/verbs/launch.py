"""Start the processes of a robot, show its run, and report the outcome.

Exit codes: 0 if the hand ends within tolerance of the goal, 3 if it does not, 1 if the run failed.
"""

import argparse
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING

from runtime.config.deployment import Deployment
from runtime.config.options import add_deployment_options, load_from
from runtime.launching.launcher import Launcher, prepare
from runtime.watching.table import say

if TYPE_CHECKING:
    from pathlib import Path

    from runtime.results.outcome import RunOutcome
    from runtime.watching.screen import Screen


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the file, its overrides, and the options for several hosts."""
    add_deployment_options(parser)
    group = parser.add_argument_group("hosts", "By default all processes start on this host.")
    which = group.add_mutually_exclusive_group()
    which.add_argument(
        "--host", metavar="NAME", help="start only the processes of this host of the file"
    )
    which.add_argument("--ssh", action="store_true", help="start the processes of each host by ssh")
    which.add_argument(
        "--rehearse",
        action="store_true",
        help="start virtual hosts on this machine, on a network that chaos can impair; needs root",
    )


def run(args: argparse.Namespace) -> int:
    """Launch the robot, print a summary, and return its exit code."""
    deployment = load_from(args)
    if args.rehearse:
        return _rehearse(deployment)
    if args.ssh:
        return _by_ssh(deployment)
    if args.host is not None:
        deployment.check_share(args.host)
    deployment, folder = prepare(deployment, host=args.host)
    outcome = Launcher(deployment, folder, _screen_of(deployment), host=args.host).go()
    return _close(deployment, folder, outcome, [] if args.host is None else ["--host", args.host])


def _rehearse(deployment: Deployment) -> int:
    from runtime.rehearsal.virtual_network import VirtualNetwork
    from runtime.spawning.remote import RemoteProcesses

    with VirtualNetwork(deployment) as network:
        deployment = network.deployment
        deployment, folder = prepare(deployment, network)
        network.build(folder)
        processes = RemoteProcesses(folder, network.hosts, away=False)
        outcome = Launcher(deployment, folder, _screen_of(deployment), network, processes).go()
    return _close(deployment, folder, outcome, ["--rehearse"])


def _by_ssh(deployment: Deployment) -> int:
    from runtime.spawning.remote import RemoteProcesses
    from runtime.spawning.ssh import connect

    deployment, folder = prepare(deployment)
    with connect(deployment, folder) as hosts:
        processes = RemoteProcesses(folder, hosts, away=True)
        outcome = Launcher(deployment, folder, _screen_of(deployment), processes=processes).go()
    return _close(deployment, folder, outcome, ["--ssh"])


def _screen_of(deployment: Deployment) -> "Callable[[], Screen]":
    def make_screen() -> "Screen":
        from runtime.watching.screen import open_screen

        return open_screen(deployment.duration)

    return make_screen


def _close(
    deployment: Deployment, folder: "Path", outcome: "RunOutcome", again: Sequence[str]
) -> int:
    from runtime.results.finishing import close

    summary, plot = close(deployment, folder, outcome, again)
    say(f"{summary.text()}\n{plot}".rstrip())
    return summary.code
