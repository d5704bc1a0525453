"""Kill the process of a role, as a crash would: the others do not notice."""

import argparse
import signal

from runtime.watching.discovery import add_target_options, target_of, visit
from runtime.watching.local import process_in


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add which robot and which role."""
    parser.add_argument("role", metavar="ROLE", help="such as joint/2; it must run on this host")
    add_target_options(parser)


def run(args: argparse.Namespace) -> int:
    """Kill it, of copies the one that is obeyed; 1 if it is not there."""
    with visit(target_of(args)) as bus:
        process = process_in(bus, args.role)
        process.send(signal.SIGKILL)
        print(f"killed {args.role}, process {process.pid}")
    return 0
