"""The configuration of a process's Zenoh session, robust to killed, hung and disconnected peers.

It connects and listens at its endpoints and nowhere else: no multicast, no gossip, and no router
unless the user has one, which then carries all traffic. With certificates it uses TLS: with QUIC,
which Zenoh offers too, peers notice a killed process only after a lease, and it adds twice the
latency.
"""

import json

import zenoh

from runtime.wire.mesh import Endpoints
from runtime.wire.security import Credentials, access_list, encryption
from runtime.wire.zenoh_internals.transport import provide_threads

_ONE_HOST = 250, 10_000, 500
"""Silence after which a connection is closed, time for an attempt to connect, and longest pause
before the next [ms].

If that time is over within the very milliseconds in which a connection is made, it is only half
made, see `Connections`: with 1 s, 5 of 180 that took 0.985 to 1.005 s."""
_SEVERAL_HOSTS = 600, 500, 100
"""The same with several hosts, or with routers. A host that is cut off does not refuse connections,
so the last two determine how soon it is found when it is back. Between hosts a packet may be lost
twice, which costs 0.4 s; reconnecting costs more."""
_LEAST = 1000
"""For an attempt with certificates, which take long to check on a busy machine, and for accepting
one [ms], at least."""
_BATCH = 2048
"""Largest batch [bytes]: twice the plant's messages of one moment. By default Zenoh has 64 KiB, and
allocates and zeroes that much for each packet while the previous one is still in use."""
_RARELY = 2000
"""Longest pause between attempts to connect to the 32 slots for copies on each host [ms]."""


def config(
    robot: str | None, place: Endpoints, credentials: Credentials | None = None
) -> zenoh.Config:
    """Return the session's configuration, and set up the threads that it will have.

    Without a robot's name, keys are those of all robots, each below its robot's name. Without
    credentials, everyone has all rights.
    """
    provide_threads(place.elsewhere)
    lease, opens, pause = _SEVERAL_HOSTS if place.elsewhere or place.routers else _ONE_HOST
    protocol, encrypted, listed = "tcp", {}, {}
    if credentials is not None and robot is not None:
        protocol, encrypted, opens = "tls", encryption(credentials), max(opens, _LEAST)
        listed = {"access_control": access_list(robot, credentials.roles, credentials.contract)}
    dials = [f"{protocol}/{there}" for there in place.routers or place.dials]
    if not place.routers:
        dials += [f"{protocol}/{copy}#retry_period_max_ms={_RARELY}" for copy in place.rarely]
    retry = {"period_init_ms": 100, "period_max_ms": pause, "period_increase_factor": 1.5}
    settings = {
        "mode": "client" if place.routers else "peer",
        "namespace": robot,
        "listen": {"endpoints": [] if place.routers else [f"{protocol}/{place.listen}"]},
        "connect": {"endpoints": dials, "retry": retry},
        "scouting": {
            "delay": 100,  # [ms] that opening waits for a dialled slot that is empty
            "multicast": {"enabled": False},
            "gossip": {"enabled": False},
        },
        "transport": {
            "link": {"tx": {"lease": lease, "keep_alive": 4, "batch_size": _BATCH}, **encrypted},
            "unicast": {"open_timeout": opens, "accept_timeout": max(opens, _LEAST)},
            "shared_memory": {"enabled": False},  # it leaks when a process is killed
        },
        **listed,
    }
    return zenoh.Config.from_json5(json.dumps(settings))
