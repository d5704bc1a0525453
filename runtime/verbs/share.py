"""Start and end processes on this host as a launcher elsewhere says: for `msma launch --ssh`."""

import argparse

from runtime.spawning.host_server import serve


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the name that shows in the list of processes."""
    parser.add_argument("host", metavar="HOST", help="the name of this host in the deployment")


def run(args: argparse.Namespace) -> int:
    """Take orders on standard input until there are no more."""
    return serve(stays=True)
