"""The threads that do Zenoh's work: one for all, or many where hosts may vanish."""

import os

from runtime.wire.zenoh_internals.features import Internal, uses

_MANY_PEERS = "net: (max_blocking_threads: 1024)"
"""In Zenoh a thread waits for each connection that is made or closed. By default there are 50, and
once all of them wait for others, it stands still for good: so robots did with about sixty
processes. Threads that are not needed are never made."""
_ONE_THREAD = (
    f"({_MANY_PEERS}, "
    "app: (handover: net), acc: (handover: net), tx: (handover: net), rx: (handover: net))"
)


def provide_threads(remote_peers: int) -> None:
    """Let one thread do all of Zenoh's work, or two for each remote peer.

    By default Zenoh has five pools of threads that hand each message on: with nine processes a tick
    is 90 changes of threads. One thread for everything needs half of them, and two thirds of the
    processor time. But closing a connection to a host that has vanished keeps a receiving thread
    busy for seconds, so with other hosts there are two for each remote peer.

    Zenoh reads the variable once, when a process opens its first session. What a user has set
    stays; what was inherited from a process without remote peers does not count.
    """
    if not uses(Internal.THREADS):
        return
    if os.environ.get("ZENOH_RUNTIME", _ONE_THREAD) == _ONE_THREAD:
        many = f"({_MANY_PEERS}, rx: (worker_threads: {2 + 2 * remote_peers}))"
        os.environ["ZENOH_RUNTIME"] = many if remote_peers else _ONE_THREAD
