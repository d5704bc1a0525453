"""Run one process of a robot in this terminal, such as an agent or the plant."""

import argparse
from pathlib import Path

from runtime.config.deployment import ProcessSpec
from runtime.config.options import add_deployment_options, load_from
from runtime.config.tree import ConfigError
from runtime.errors import valid_are
from runtime.processes.roles import live
from runtime.spawning.registry import forget, join_run


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_deployment_options(parser)
    parser.add_argument(
        "role", metavar="ROLE", help="role, such as joint/2, platform, goal or plant"
    )
    parser.add_argument(
        "--run",
        metavar="FOLDER",
        type=Path,
        help="folder for the log (default: that of the running processes, or a new one)",
    )
    parser.add_argument(
        "--copy",
        action="store_true",
        help="run beside the process in this role, which becomes a standby",
    )
    parser.add_argument(
        "--host", metavar="NAME", help="with --copy: the host that this is, if not the role's own"
    )


def run(args: argparse.Namespace) -> int:
    """Run until the run ends, it is stopped, or the plant is silent for too long."""
    deployment = load_from(args, only_role=args.role)
    if args.host is not None and (not args.copy or args.host not in deployment.hosts):
        hint = valid_are(args.host, deployment.hosts)
        raise ConfigError(f"--host {args.host}: needs --copy and a host of the file{hint}")
    home = args.host or deployment.host_of(args.role)
    member = ProcessSpec(args.role, home, copy=args.copy)
    deployment, folder = join_run(deployment, args.run)
    try:
        return live(deployment, member, Path(args.file), folder)
    finally:
        forget(deployment.robot, folder)
