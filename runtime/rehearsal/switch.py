"""The network of a rehearsal: a process that carries Ethernet frames between cables.

It ends with the launcher that started it, whose end of `control` closes then.
"""

import heapq
import json
import os
import random
import selectors
import signal
import socket
import sys
import time
from contextlib import suppress
from itertools import count

from setproctitle import setproctitle

from runtime.rehearsal.links import Links, trouble_of

_LARGEST = 65536  # [bytes] of a frame
_AT_ONCE = 64  # frames from a cable before the others have their turn
_WAITING = 20_000  # frames on the way, at most: more are lost as in any switch


class Switch:
    """Sends each frame to the host that has its address, or to all others if that is not known.

    cables: the file of each host's cable
    """

    def __init__(self, cables: dict[str, int], links: Links) -> None:
        self._cables, self._links = cables, links
        self._owners: dict[bytes, str] = {}  # of each Ethernet address
        self._waiting: list[tuple[float, int, str, bytes]] = []
        self._number = count()

    def take(self, host: str) -> bool:
        """Take what a host has sent; tell whether its cable is still there."""
        for _ in range(_AT_ONCE):
            try:
                frame = os.read(self._cables[host], _LARGEST)
            except BlockingIOError:
                return True
            except OSError:  # its namespace has gone
                return False
            self._forward(host, frame)
        return True

    def _forward(self, sender: str, frame: bytes) -> None:
        to, source = frame[:6], frame[6:12]
        self._owners[source] = sender
        known = self._owners.get(to)
        now = time.monotonic()
        for receiver in self._cables if known is None else (known,):
            due = None if receiver == sender else self._links.due(sender, receiver, now)
            if due is not None and len(self._waiting) < _WAITING:
                heapq.heappush(self._waiting, (due, next(self._number), receiver, frame))

    def deliver(self) -> float | None:
        """Deliver what is due; return in how many seconds the next is, None if nothing waits."""
        while self._waiting:
            wait = self._waiting[0][0] - time.monotonic()
            if wait > 0:
                return wait
            _, _, receiver, frame = heapq.heappop(self._waiting)
            with suppress(OSError):  # its cable is gone, or full
                os.write(self._cables[receiver], frame)
        return None


def main() -> None:
    """Carry frames until the control socket closes: `switch CONTROL SEED NAME=FILE...`."""
    setproctitle("msma switch of a rehearsal")
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the launcher
    number, seed, *pairs = sys.argv[1:]
    cables = {name: int(file) for name, _, file in (pair.rpartition("=") for pair in pairs)}
    links = Links(random.Random(int(seed)))
    switch = Switch(cables, links)
    with socket.socket(fileno=int(number)) as control, selectors.DefaultSelector() as ready:
        ready.register(control, selectors.EVENT_READ, None)
        for host, file in cables.items():
            ready.register(file, selectors.EVENT_READ, host)
        while True:
            for key, _ in ready.select(switch.deliver()):
                if key.data is None:
                    order = control.recv(_LARGEST)
                    if not order:
                        return
                    _obey(links, json.loads(order))
                    control.send(b"done")
                elif not switch.take(key.data):
                    ready.unregister(key.fileobj)


def _obey(links: Links, order: dict[str, object]) -> None:
    if trouble := order.get("trouble"):
        assert isinstance(trouble, dict)
        links.begin(str(order["name"]), trouble_of(trouble, trouble["hosts"]))
    else:
        links.end(str(order["name"]))


if __name__ == "__main__":
    main()
