"""Bring a running robot to rest, and keep it there until it is released.

It needs the robot's computer, the network and the plant's process: it is no emergency stop.
"""

import argparse
import getpass
import socket
import sys

from runtime.errors import NotConfirmed
from runtime.watching.control import Control
from runtime.watching.discovery import add_target_options, join, target_of

_GIVES_UP = 3.0  # [s] without an answer


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_target_options(parser)


def run(args: argparse.Namespace) -> int:
    """Halt it at once, not waiting for processes that hang; go on trying if that is not confirmed.

    The exit code is 0 only if the plant has confirmed it.
    """
    target = target_of(args)
    try:
        user = getpass.getuser()
    except (OSError, KeyError):  # one whom this system does not know
        user = "somebody"
    by = f"{user} on {socket.gethostname()}"
    with join(target) as bus:
        control = Control(bus)
        try:
            state, after = control.halt(by)
        except NotConfirmed as error:
            print(f"msma: {error}", file=sys.stderr, flush=True)
            state, after = control.halt(by, _GIVES_UP)
    before = "" if state.halted_by == by else f" (as it was already, by {state.halted_by})"
    print(f"{target.robot} is halted{before}, confirmed by its plant after {1e3 * after:.0f} ms")
    print("`msma release` ends that")
    return 0
