"""Where the processes of a robot listen and whom they dial: a mesh that any one may leave.

Each process has a slot with a port of its own and dials the lower slots only. Of every two the
higher one dials, so they never end up with half a connection each; and whoever dies, newcomers
are still dialled by the higher and dial the lower ones.
"""

import json
from typing import NamedTuple

import zenoh

from runtime.wire.ports import FIRST_COPY, SLOTS

HOST = "127.0.0.1"


class Place(NamedTuple):
    """Where a process listens (port 0: anywhere) and which ports it dials, all on this host."""

    listen: int
    dials: tuple[int, ...]


def seat(base: int, slot: int, slots: int) -> Place:
    """Return the place of a role's slot, or of a copy's slot beside `slots` roles."""
    lower = [*range(min(slot, slots)), *range(FIRST_COPY, slot)]
    return Place(base + slot, tuple(base + one for one in lower))


def visitor(base: int, roles: int = FIRST_COPY) -> Place:
    """Return the place of a tool, which dials all roles and copies and is dialled by none.

    Dialling 128 slots of which 10 answer costs it 0.1 s at the start and 2 % of a core, so one
    that stays long should say how many roles there are.
    """
    return Place(0, tuple(base + slot for slot in (*range(roles), *range(FIRST_COPY, SLOTS))))


def config(robot: str | None, place: Place) -> zenoh.Config:
    """Return the session's configuration: what held when processes were killed and stopped.

    Without a robot's name, keys are those of all robots, each below its robot's name.
    """
    return zenoh.Config.from_json5(
        json.dumps(
            {
                "mode": "peer",
                "namespace": robot,
                "listen": {"endpoints": [f"tcp/{HOST}:{place.listen}"]},
                "connect": {
                    "endpoints": [f"tcp/{HOST}:{port}" for port in place.dials],
                    "retry": {
                        "period_init_ms": 100,
                        "period_max_ms": 500,
                        "period_increase_factor": 1.5,
                    },
                },
                "scouting": {
                    "delay": 100,  # [ms] that opening waits for a dialled slot that is empty
                    "multicast": {"enabled": False},
                    "gossip": {"enabled": False},
                },
                "transport": {
                    "link": {"tx": {"lease": 250, "keep_alive": 4}},  # [ms], keep-alives a lease
                    "unicast": {"open_timeout": 1000, "accept_timeout": 1000},  # [ms]
                    "shared_memory": {"enabled": False},  # it leaks when a process is killed
                },
            }
        )
    )
