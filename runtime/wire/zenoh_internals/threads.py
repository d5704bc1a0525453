"""The threads that do Zenoh's work: one for all, or many where hosts may vanish."""

import os

from runtime.wire.zenoh_internals.features import Internal, uses

_MANY_PEERS = "net: (max_blocking_threads: 1024)"
"""Zenoh has a thread wait for each connection that it makes or closes. There are 50 by default, and
once all wait for others to be free it stands still for good, as a robot's processes did from some
sixty on. Those that are not needed are never made."""
_ONE_THREAD = (
    f"({_MANY_PEERS}, "
    "app: (handover: net), acc: (handover: net), tx: (handover: net), rx: (handover: net))"
)


def provide_threads(elsewhere: int) -> None:
    """Let one thread do all of Zenoh's work, or let no cut cable hold up what comes from others.

    By default it has five pools of threads that hand each message on to each other: with nine
    processes a tick is 90 changes of threads, and half of that with one thread for all, in two
    thirds of the processors' time. But closing a connection that leads nowhere keeps a receiving
    thread busy for seconds: where other hosts may vanish, that takes two for each remote peer.
    Zenoh reads this once, when a process opens its first session. What a user has set stays; what
    was inherited from a process that had no remote peers does not count.
    """
    if not uses(Internal.THREADS):
        return
    if os.environ.get("ZENOH_RUNTIME", _ONE_THREAD) == _ONE_THREAD:
        many = f"({_MANY_PEERS}, rx: (worker_threads: {2 + 2 * elsewhere}))"
        os.environ["ZENOH_RUNTIME"] = many if elsewhere else _ONE_THREAD
