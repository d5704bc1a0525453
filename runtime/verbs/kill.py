"""Kill the process of a role on this host with SIGKILL."""

import argparse
import signal

from runtime.watching.discovery import add_target_options, target_of, visit
from runtime.watching.local import process_in


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the role and the options that name a robot."""
    parser.add_argument(
        "role", metavar="ROLE", help="role, such as joint/2; its process must run on this host"
    )
    add_target_options(parser)


def run(args: argparse.Namespace) -> int:
    """Kill the process; of several copies the one whose commands are accepted."""
    target = target_of(args)
    with visit(target) as bus:
        process = process_in(bus, target, args.role)
        process.send(signal.SIGKILL)
        print(f"killed {args.role}, process {process.pid}")
    return 0
