"""How a process's Zenoh session is set up: what held when others were killed, stopped and cut off.

It dials and listens where its place says and nowhere else: no multicast, no gossip, no router.
"""

import json
import os

import zenoh

from runtime.wire.mesh import Address, Place


def endpoint(address: Address) -> str:
    """Return an address as Zenoh wants it: the one place where the protocol is chosen."""
    return f"tcp/{address}"


def config(robot: str | None, place: Place) -> zenoh.Config:
    """Return the session's configuration, and set up the threads that it will have.

    Without a robot's name, keys are those of all robots, each below its robot's name.
    """
    _provide_threads(place.elsewhere)
    return zenoh.Config.from_json5(
        json.dumps(
            {
                "mode": "peer",
                "namespace": robot,
                "listen": {"endpoints": [endpoint(place.listen)]},
                "connect": {
                    "endpoints": [endpoint(address) for address in place.dials],
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


def _provide_threads(elsewhere: int) -> None:
    """Let no cut cable hold up what comes from others: that takes two threads a remote peer.

    Closing a connection that leads nowhere keeps a receiving thread of Zenoh busy for seconds,
    and by default there are two. It reads this once, when a process opens its first session.
    """
    if elsewhere:
        os.environ.setdefault("ZENOH_RUNTIME", f"(rx: (worker_threads: {2 + 2 * elsewhere}))")
