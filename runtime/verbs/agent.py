"""Be one process of a running robot, here and now: an agent, the goal source or the plant."""

import argparse
from pathlib import Path

from runtime.config.deployment import ProcessSpec
from runtime.config.options import add_deployment_options, load_from
from runtime.config.tree import ConfigError
from runtime.errors import valid_are
from runtime.processes.roles import live


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the file, the role, and where to log."""
    add_deployment_options(parser)
    parser.add_argument("role", metavar="ROLE", help="such as joint/2, platform, goal or plant")
    parser.add_argument(
        "--run",
        metavar="FOLDER",
        type=Path,
        help="folder of the log; by default that of the robot's running processes, or a new one",
    )
    parser.add_argument(
        "--copy",
        action="store_true",
        help="run beside the process that has this role: it takes over, the other stands by",
    )
    parser.add_argument("--host", metavar="NAME", help="on which host a copy runs, if not there")


def run(args: argparse.Namespace) -> int:
    """Live until the run ends, somebody stops it, or no plant is heard for too long."""
    deployment = load_from(args, only_role=args.role)
    if args.host is not None and (not args.copy or args.host not in deployment.hosts):
        hint = valid_are(args.host, deployment.hosts)
        raise ConfigError(f"--host {args.host}: it goes with --copy, on a host of the file{hint}")
    home = args.host or deployment.host_of(args.role)
    member = ProcessSpec(args.role, home, copy=args.copy)
    return live(deployment, member, Path(args.file), args.run)
