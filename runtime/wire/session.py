"""How a process's Zenoh session is set up: what held when others were killed, stopped and cut off.

It dials and listens where its place says and nowhere else: no multicast, no gossip, and no router
unless the user has one, through which all goes then.
Where certificates are asked for it speaks TLS: of QUIC, which Zenoh has too, the others notice
only after a lease that a process was killed, and an answer takes twice as much longer.
"""

import json
import os
from typing import NamedTuple

import zenoh

from runtime.wire.mesh import Endpoints
from runtime.wire.security import Credentials, access_list, encryption


class _Patience(NamedTuple):
    """How long to wait for what [ms].

    lease: silence after which a connection is given up
    open, pause: to try to connect before trying anew, and to pause at most before that; a host
        that is cut off does not refuse, so these say how soon it is found when it is back, and
        how long a session may take to close
    """

    lease: int
    open: int
    pause: int


_AT_HOME = _Patience(lease=250, open=1000, pause=500)
_ACROSS = _Patience(lease=600, open=500, pause=100)
"""With other hosts a packet may be lost twice, which costs 0.4 s; to connect anew costs more."""


_TLS_OPEN = 1000
"""Certificates take a busy machine long to check, and to give up amid that may never be mended:
Zenoh can then take a connection for there that is not, until one of the two processes ends."""
_BATCH = 2048
"""The most that goes at once [bytes]: twice what the plant tells of a moment. By default Zenoh has
64 KiB, and makes so much anew, all zeros, for each packet while the one before is still held."""
_RARELY = 2000
"""Pause [ms] at most before dialling anew where copies may be: 32 places of each host."""


def config(
    robot: str | None, place: Endpoints, credentials: Credentials | None = None
) -> zenoh.Config:
    """Return the session's configuration, and set up the threads that it will have.

    Without a robot's name, keys are those of all robots, each below its robot's name. Without
    credentials, everybody may do everything.
    """
    _provide_threads(place.elsewhere)
    patience = _ACROSS if place.elsewhere else _AT_HOME
    protocol, encrypted, listed = "tcp", {}, {}
    if credentials is not None and robot is not None:
        protocol, encrypted = "tls", encryption(credentials)
        patience = patience._replace(open=_TLS_OPEN)
        listed = {"access_control": access_list(robot, credentials.roles, credentials.contract)}
    return zenoh.Config.from_json5(
        json.dumps(
            {
                "mode": "client" if place.routers else "peer",
                "namespace": robot,
                "listen": {"endpoints": [] if place.routers else [f"{protocol}/{place.listen}"]},
                "connect": {
                    "endpoints": _dials(protocol, place),
                    "retry": {
                        "period_init_ms": 100,
                        "period_max_ms": patience.pause,
                        "period_increase_factor": 1.5,
                    },
                },
                "scouting": {
                    "delay": 100,  # [ms] that opening waits for a dialled slot that is empty
                    "multicast": {"enabled": False},
                    "gossip": {"enabled": False},
                },
                "transport": {
                    "link": {
                        "tx": {"lease": patience.lease, "keep_alive": 4, "batch_size": _BATCH},
                        **encrypted,
                    },
                    "unicast": {"open_timeout": patience.open, "accept_timeout": 1000},  # [ms]
                    "shared_memory": {"enabled": False},  # it leaks when a process is killed
                },
                **listed,
            }
        )
    )


def _dials(protocol: str, place: Endpoints) -> list[str]:
    if place.routers:
        return [f"{protocol}/{there}" for there in place.routers]
    often = [f"{protocol}/{there}" for there in place.dials]
    return often + [f"{protocol}/{there}#retry_period_max_ms={_RARELY}" for there in place.rarely]


_MANY_PEERS = "net: (max_blocking_threads: 1024)"
"""Zenoh has a thread wait for each connection that it makes or closes. There are 50 by default, and
once all wait for others to be free it stands still for good, as a robot's processes did from some
sixty on. Those that are not needed are never made."""
_ONE_THREAD = (
    f"({_MANY_PEERS}, "
    "app: (handover: net), acc: (handover: net), tx: (handover: net), rx: (handover: net))"
)


def _provide_threads(elsewhere: int) -> None:
    """Let one thread do all of Zenoh's work, or let no cut cable hold up what comes from others.

    By default it has five pools of threads that hand each message on to each other: with nine
    processes a tick is 90 changes of threads, and half of that with one thread for all, in two
    thirds of the processors' time. But closing a connection that leads nowhere keeps a receiving
    thread busy for seconds: where other hosts may vanish, that takes two for each remote peer.
    Zenoh reads this once, when a process opens its first session. What a user has set stays; what
    was inherited from a process that had no remote peers does not count.
    """
    if os.environ.get("ZENOH_RUNTIME", _ONE_THREAD) == _ONE_THREAD:
        many = f"({_MANY_PEERS}, rx: (worker_threads: {2 + 2 * elsewhere}))"
        os.environ["ZENOH_RUNTIME"] = many if elsewhere else _ONE_THREAD
