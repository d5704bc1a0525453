"""The network of a rehearsal: a process that switches Ethernet frames between TAP devices.

It ends with its launcher, when the other end of the control socket closes.
"""

import heapq
import os
import random
import selectors
import signal
import socket
import sys
import time
from contextlib import suppress
from itertools import count

import msgspec
from setproctitle import setproctitle

from runtime.rehearsal.links import Impairment, Links

_MAX_FRAME = 65536  # [bytes] of a frame
_BATCH = 64  # frames read from one device before the next device
_MAX_WAITING = 20_000  # frames in transit; further ones are dropped, as in any switch


class Switch:
    """Forwards each frame to the host with its address, or to all if the address is unknown.

    Args:
        taps: The file descriptor of each host's TAP device.
        links: Decides when a frame arrives.
    """

    def __init__(self, taps: dict[str, int], links: Links) -> None:
        self._taps, self._links = taps, links
        self._owners: dict[bytes, str] = {}  # of each Ethernet address
        self._waiting: list[tuple[float, int, str, bytes]] = []
        self._number = count()

    def receive(self, host: str) -> bool:
        """Forward what a host has sent; return whether its device still exists."""
        for _ in range(_BATCH):
            try:
                frame = os.read(self._taps[host], _MAX_FRAME)
            except BlockingIOError:
                return True
            except OSError:  # its namespace has ended
                return False
            self._forward(host, frame)
        return True

    def _forward(self, sender: str, frame: bytes) -> None:
        to, source = frame[:6], frame[6:12]
        self._owners[source] = sender
        known = self._owners.get(to)
        now = time.monotonic()
        for receiver in self._taps if known is None else (known,):
            due = None if receiver == sender else self._links.due(sender, receiver, now)
            if due is not None and len(self._waiting) < _MAX_WAITING:
                heapq.heappush(self._waiting, (due, next(self._number), receiver, frame))

    def deliver(self) -> float | None:
        """Deliver what is due; return the time [s] until the next delivery, None if none waits."""
        while self._waiting:
            wait = self._waiting[0][0] - time.monotonic()
            if wait > 0:
                return wait
            _, _, receiver, frame = heapq.heappop(self._waiting)
            with suppress(OSError):  # its device is gone, or its queue is full
                os.write(self._taps[receiver], frame)
        return None


def main() -> None:
    """Switch frames until the control socket closes: `switch CONTROL SEED NAME=FILE...`."""
    setproctitle("msma rehearsal switch")
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the launcher handles Ctrl-C
    number, seed, *pairs = sys.argv[1:]
    taps = {name: int(file) for name, _, file in (pair.rpartition("=") for pair in pairs)}
    links = Links(random.Random(int(seed)))
    switch = Switch(taps, links)
    with socket.socket(fileno=int(number)) as control, selectors.DefaultSelector() as ready:
        ready.register(control, selectors.EVENT_READ, None)
        for host, file in taps.items():
            ready.register(file, selectors.EVENT_READ, host)
        while True:
            for key, _ in ready.select(switch.deliver()):
                if key.data is None:
                    request = control.recv(_MAX_FRAME)
                    if not request:
                        return
                    links.impairments = msgspec.json.decode(request, type=list[Impairment])
                    control.send(b"done")
                elif not switch.receive(key.data):
                    ready.unregister(key.fileobj)


if __name__ == "__main__":
    main()
