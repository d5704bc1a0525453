"""Stop a running robot, or one of its roles."""

import argparse
import time

from runtime.errors import RunError
from runtime.watching.control import Control
from runtime.watching.discovery import add_target_options, target_of, visit
from runtime.wire import topics
from runtime.wire.bus import Bus

_PATIENCE = 3.0  # [s] for all processes to end


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the role and the options that name a robot."""
    parser.add_argument(
        "role", metavar="ROLE", nargs="?", help="role, such as joint/2 (default: all)"
    )
    add_target_options(parser)


def run(args: argparse.Namespace) -> int:
    """Request the stop, and wait until the processes have ended."""
    with visit(target_of(args)) as bus:
        wanted = _tokens(bus, args.role)
        if not wanted:
            raise RunError(f"no {args.role} runs")
        Control(bus).stop(args.role or "**")
        until = time.monotonic() + _PATIENCE
        while (left := wanted & _tokens(bus, args.role)) and time.monotonic() < until:
            time.sleep(0.05)
    if left:
        roles = ", ".join(sorted(_role(token) for token in left))
        raise RunError(f"{roles}: does not stop; use `msma kill ROLE` for a process that hangs")
    print(f"stopped: {', '.join(sorted(_role(token) for token in wanted))}")
    return 0


def _tokens(bus: Bus, role: str | None) -> set[str]:
    """Return the liveliness tokens of a role, or of all roles."""
    return {token for token in bus.who_is_alive() if role is None or _role(token) == role}


def _role(token: str) -> str:
    who = topics.who_is_alive(token)
    return "" if who is None else who[0]
