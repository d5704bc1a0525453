"""One process of the plain echo that does our thinking as well: what a loop in Python can reach.

A plant that simulates and agents that decide, with nothing around it: no message is read or
checked, no percept is put together, nothing is logged. What they think about was recorded.
"""

from collections.abc import Callable
from itertools import cycle

from bench.echo.load import GOAL, part_of
from bench.echo.plain_zenoh import be, nothing
from bench.thinking import arm_run
from runtime.wire.keys import PLANT

_RECORDED = 200  # ticks


def thought_of(role: str, period: float) -> Callable[[], object]:
    """Return what the process of a role thinks each tick of `period` [s], once per call."""
    if role == GOAL:
        return nothing
    run = arm_run(_RECORDED, period)
    if role == PLANT:
        commands = run.commands
        return lambda: run.plant.step(commands)
    agent = run.agents[role]
    seen = cycle(run.seen)
    return lambda: agent.decide(next(seen))


def main() -> None:
    """Be the part that the command line names."""
    part = part_of()
    be(part, thought_of(part.role, 1 / part.rate))


if __name__ == "__main__":
    main()
