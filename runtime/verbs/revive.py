"""Start the process of a role again in a running robot."""

import argparse
import time

from runtime.spawning.forkserver import ForkServer
from runtime.watching.discovery import add_target_options


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_target_options(parser, role="role, such as joint/2")


def run(args: argparse.Namespace) -> int:
    """Start the process, and wait until it has joined the robot."""
    began = time.monotonic()
    with ForkServer(args.role) as forkserver:  # it imports while this one looks for the robot
        from runtime.watching.discovery import target_of
        from runtime.watching.local import revive

        pid = revive(args.role, target_of(args), forkserver)
    print(f"{args.role} runs again, process {pid}, {time.monotonic() - began:.2f} s")
    return 0
