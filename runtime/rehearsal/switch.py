"""The network of a rehearsal: a process that passes IP packets from one virtual host to another.

It ends with its launcher, when its standard input closes.
"""

import heapq
import os
import random
import selectors
import socket
import sys
import time
from contextlib import suppress
from itertools import count

import msgspec
from setproctitle import setproctitle

from runtime.config.chaos import ChaosEvent

_MAX_PACKET = 65536  # [bytes]
_BATCH = 64  # packets read from one host before the next host
_MAX_WAITING = 20_000  # packets in transit; further ones are dropped, as in any switch


class Links:
    """Decides when a packet arrives; packets from one host to another keep their order."""

    def __init__(self, rng: random.Random) -> None:
        self._rng = rng  # of jitter and loss
        self.impairments: list[ChaosEvent] = []  # those of the traffic now
        self._last: dict[tuple[str, str], float] = {}

    def due(self, sender: str, receiver: str, now: float) -> float | None:
        """Return when a packet sent `now` [s] arrives [s]; None if it is lost."""
        due = now
        for event in self.impairments:
            ends = (sender in event.hosts) + (receiver in event.hosts)
            if event.partition and ends == 1:
                return None
            if ends and self._rng.random() < (event.share or 0.0):
                return None
            if ends and event.time:
                due += event.time + self._rng.uniform(-1.0, 1.0) * (event.jitter or 0.0)
        link = (sender, receiver)
        self._last[link] = max(due, self._last.get(link, now))
        return self._last[link]


class Switch:
    """Passes each packet on to the host with its address.

    Args:
        hosts: Name of each host by its address, in the four bytes that packets have.
        tuns: The file descriptor of each host's TUN device.
    """

    def __init__(self, links: Links, hosts: dict[bytes, str], tuns: dict[str, int]) -> None:
        self._links, self._hosts, self._tuns = links, hosts, tuns
        self._waiting: list[tuple[float, int, str, bytes]] = []
        self._number = count()

    def receive(self, sender: str) -> None:
        """Take what a host has sent."""
        with suppress(BlockingIOError):
            for _ in range(_BATCH):
                packet = os.read(self._tuns[sender], _MAX_PACKET)
                receiver = self._hosts.get(packet[16:20], sender)
                due = self._links.due(sender, receiver, time.monotonic())
                if due is not None and receiver != sender and len(self._waiting) < _MAX_WAITING:
                    heapq.heappush(self._waiting, (due, next(self._number), receiver, packet))

    def deliver(self) -> float | None:
        """Deliver what is due; return the time [s] until the next delivery, None if none waits."""
        while self._waiting:
            wait = self._waiting[0][0] - time.monotonic()
            if wait > 0:
                return wait
            _, _, receiver, packet = heapq.heappop(self._waiting)
            with suppress(OSError):  # its queue is full
                os.write(self._tuns[receiver], packet)
        return None


def main() -> None:
    """Pass packets on until standard input closes: `switch SEED FILE=ADDRESS=NAME...`."""
    setproctitle("msma rehearsal switch")
    links = Links(random.Random(int(sys.argv[1])))
    hosts = [each.split("=", 2) for each in sys.argv[2:]]
    addresses = {socket.inet_aton(address): name for _, address, name in hosts}
    switch = Switch(links, addresses, {name: int(file) for file, _, name in hosts})
    with selectors.DefaultSelector() as ready:
        ready.register(sys.stdin, selectors.EVENT_READ)
        for file, _, name in hosts:
            ready.register(int(file), selectors.EVENT_READ, name)
        while True:
            for key, _ in ready.select(switch.deliver()):
                if key.data is not None:
                    switch.receive(key.data)
                elif line := sys.stdin.readline():
                    links.impairments = msgspec.json.decode(line, type=list[ChaosEvent])
                    print("done", flush=True)
                else:
                    return


if __name__ == "__main__":
    main()
