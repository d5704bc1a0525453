"""Stop a running robot, or one of its roles."""

import argparse
import time

from runtime.errors import RunError
from runtime.spawning.identity import ProcessId, all_in
from runtime.watching.control import Control
from runtime.watching.discovery import Target, add_target_options, target_of, visit
from runtime.wire import topics
from runtime.wire.bus import Bus

_PATIENCE = 3.0  # [s] for all processes to end
_CONNECTS = 2.0  # [s] for the process of a role to connect, on a busy machine
_LATE = 0.3  # [s] after which none is expected that connects so late that it was not asked yet
_SUCCESSOR = "successor"  # of a launcher that was killed, which ends with the run


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "role", metavar="ROLE", nargs="?", help="role, such as joint/2 (default: all)"
    )
    add_target_options(parser)


def run(args: argparse.Namespace) -> int:
    """Request the stop, again as long as any runs, and wait until the processes have ended."""
    target = target_of(args)
    with visit(target) as bus:
        began = time.monotonic()
        while not (wanted := _alive(bus, args.role)):  # some other role is there
            if time.monotonic() > began + _CONNECTS:
                raise RunError(f"no {args.role} runs")
            time.sleep(0.05)
        control = Control(bus)
        control.stop(args.role or "**")  # at once: it may take a while to read the logs
        here = _processes(target, args.role)
        asked = {role for role, _ in (*wanted, *here)}
        left, began = wanted, time.monotonic()
        ended = began
        while (now := time.monotonic()) < began + _PATIENCE and (
            left or here or now < ended + _LATE
        ):
            if left or here:
                control.stop(args.role or "**")
                ended = time.monotonic()
            time.sleep(0.05)
            left = _alive(bus, args.role)
            if args.role:
                left &= wanted  # and not one that is revived meanwhile
            asked |= {role for role, _ in left}
            here = [each for each in here if each[1].lives()]
    if hang := {role for role, _ in (*left, *here)}:
        raise RunError(
            f"{_listed(hang)}: does not stop; use `msma kill ROLE` for a process that hangs"
        )
    print(f"stopped: {_listed(asked)}")
    return 0


def _processes(target: Target, role: str | None) -> list[tuple[str, ProcessId]]:
    """Return the processes here of a role, or of all roles, and their roles.

    One that has been held up for a while is not seen alive, and goes on if it is not asked again.
    """
    found = [each for run in target.runs for each in all_in(run)]
    return [each for each in found if each[0] != _SUCCESSOR and role in (None, each[0])]


def _alive(bus: Bus, role: str | None) -> set[tuple[str, int]]:
    """Return role and incarnation of each process of a role, or of all roles."""
    alive = map(topics.who_is_alive, bus.who_is_alive())
    return {who for who in alive if who and role in (None, who[0])}


def _listed(roles: set[str]) -> str:
    return ", ".join(sorted(roles))
