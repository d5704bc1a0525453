"""Be one process of a running robot, here and now: an agent, the goal source or the plant."""

import argparse
from pathlib import Path

from runtime.config.options import add_deployment_options, load_from
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


def run(args: argparse.Namespace) -> int:
    """Live until the run ends, somebody stops it, or no plant is heard for too long."""
    deployment = load_from(args, only_role=args.role)
    return live(deployment, args.role, Path(args.file), args.run, copy=args.copy)
