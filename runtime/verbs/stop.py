"""Ask a running robot to stop, all of it or one role, and see that it does."""

import argparse
import time

from runtime.errors import RunError
from runtime.watching.discovery import add_target_options, target_of, visit
from runtime.wire import topics
from runtime.wire.bus import Bus

_PATIENCE = 3.0  # [s] for all to be gone
_ANSWER = 1.0  # [s]


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add which robot and which role."""
    parser.add_argument("role", metavar="ROLE", nargs="?", help="by default all")
    add_target_options(parser)


def run(args: argparse.Namespace) -> int:
    """Stop it; 1 if it does not."""
    with visit(target_of(args)) as bus:
        wanted = _tokens(bus, args.role)
        if not wanted:
            raise RunError(f"no {args.role} runs")
        bus.ask(topics.stop(args.role or "**"), timeout=_ANSWER)
        until = time.monotonic() + _PATIENCE
        while (left := wanted & _tokens(bus, args.role)) and time.monotonic() < until:
            time.sleep(0.05)
    if left:
        roles = ", ".join(sorted(_role(token) for token in left))
        raise RunError(f"{roles}: does not stop; `msma kill ROLE` ends what hangs")
    print(f"stopped: {', '.join(sorted(_role(token) for token in wanted))}")
    return 0


def _tokens(bus: Bus, role: str | None) -> set[str]:
    """Return the tokens of those alive in a role, or of all."""
    return {token for token in bus.who_is_alive() if role is None or _role(token) == role}


def _role(token: str) -> str:
    who = topics.who_is_alive(token)
    return "" if who is None else who[0]
