"""Start the processes of a robot, show its run, and report the outcome.

Exit codes: 0 if the hand ends within tolerance of the goal, 3 if it does not, 1 if the run failed.
"""

import argparse
from contextlib import ExitStack

from runtime.config.options import add_deployment_options, load_from
from runtime.config.tree import ConfigError
from runtime.errors import valid_are
from runtime.launching.launcher import Launcher, prepare
from runtime.watching.table import say


def add_arguments(parser: argparse.ArgumentParser) -> None:
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
    deployment = load_from(args)
    again = [f"--{how}" for how in ("ssh", "rehearse") if getattr(args, how)]
    network = hosts = processes = None
    with ExitStack() as stack:
        if args.host is not None:
            busy = dict.fromkeys(one.host for one in deployment.processes)
            if args.host not in busy:
                hint = valid_are(args.host, busy)
                raise ConfigError(f"no process runs on a host {args.host!r}{hint}")
            again = ["--host", args.host]
        if args.rehearse:
            from runtime.rehearsal.virtual_network import VirtualNetwork

            network = stack.enter_context(VirtualNetwork(deployment))
            deployment, hosts = network.deployment, network.hosts
        deployment, folder = prepare(deployment, network, args.host)
        if network is not None:
            network.build(folder)
        if args.ssh:
            from runtime.spawning.remote import connect

            hosts = stack.enter_context(connect(deployment, folder))
        if hosts is not None:
            from runtime.spawning.remote import RemoteProcesses

            processes = RemoteProcesses(folder, hosts, away=args.ssh)
        outcome = Launcher(deployment, folder, network, processes, args.host).go()
    from runtime.results.summary import close

    summary, plot = close(deployment, folder, outcome, again)
    say(f"{summary.text()}\n{plot}".rstrip())
    return summary.code
