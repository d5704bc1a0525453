"""Start and end processes on this host for `msma launch --ssh` on another host."""

import argparse

from runtime.spawning.host_server import serve


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("host", metavar="HOST", help="name of this host in the deployment")


def run(args: argparse.Namespace) -> int:
    return serve(stays=True)
