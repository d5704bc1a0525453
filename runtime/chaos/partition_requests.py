"""Partitions that are asked for while a rehearsal runs: what may be asked, and what is due when.

They begin and end in real time: plant time stands still for a launcher that is cut off from the
plant. There is no clock in here.
"""

import math
import os
from collections.abc import Collection
from queue import SimpleQueue

from runtime.chaos.schedule import Due
from runtime.config.chaos import ChaosEvent
from runtime.config.deployment import Deployment
from runtime.config.tree import ConfigError
from runtime.errors import valid_are

REHEARSAL = "MSMA_REHEARSAL"
"""The environment variable that the processes of a rehearsal have."""
SHORTEST = 0.1
"""The shortest partition that may be asked for [s]."""
_LONGEST = 60.0  # [s]
_OF_PATIENCE = 0.8  # in the rest of it, those who are back have to hear the plant again
_NOTICE = 0.2  # [s] for the answer to reach who asks, who may be on a host that is cut off then


def longest(deployment: Deployment) -> float:
    """Return the longest partition that may be asked for [s]: its hosts are to come back from it.

    After `patience` without the plant the processes there would end for good.
    """
    return min(_LONGEST, _OF_PATIENCE * deployment.patience)


def is_rehearsal() -> bool:
    """Tell whether this process is on a virtual host."""
    return REHEARSAL in os.environ


def read(text: str, valid: Collection[str], most: float) -> tuple[tuple[str, ...], float]:
    """Return the hosts and the seconds of a request; `ConfigError` if it cannot be carried out.

    Args:
        text: The request, such as `arm,base 2.5`.
        valid: All hosts.
        most: The longest that a partition may be [s].
    """
    names, _, time = text.partition(" ")
    hosts = tuple(dict.fromkeys(names.split(",")))
    for host in hosts:
        if host not in valid:
            raise ConfigError(f"there is no host {host!r}{valid_are(host, valid)}")
    try:
        seconds = float(time)
    except ValueError:
        seconds = math.nan
    if not SHORTEST <= seconds <= most:
        what = f"a partition on request lasts {SHORTEST:g} to {most:g} s"
        raise ConfigError(f"{what}, not {time[:40] or 'for no time'}")
    return hosts, seconds


class PartitionRequests:
    """Takes requests in a thread of the bus, and hands out to the launcher what is due.

    Args:
        possible: Whether hosts can be cut off from each other, as in a rehearsal.
    """

    def __init__(self, deployment: Deployment, *, possible: bool) -> None:
        self._deployment, self._possible = deployment, possible
        self._asked = SimpleQueue[tuple[tuple[str, ...], float]]()
        self._left: list[tuple[float, Due]] = []  # with the real time of each [s]

    def take(self, question: bytes) -> bytes:
        """Take a request, and answer it; `ConfigError` if it is refused."""
        if not self._possible:
            what = "hosts can be cut off in a rehearsal only: msma launch FILE --rehearse"
            raise ConfigError(f"{self._deployment.robot} is no rehearsal; {what}")
        text = question.decode(errors="replace")
        hosts, seconds = read(text, self._deployment.hosts, longest(self._deployment))
        self._asked.put((hosts, seconds))
        return f"{', '.join(hosts)} cut off for {seconds:g} s".encode()

    def due(self, t: float, now: float) -> list[Due]:
        """Return what is due `now` [s], in the order of times, at plant time `t` [s]."""
        while not self._asked.empty():
            hosts, seconds = self._asked.get()
            event = ChaosEvent(at=t, partition=hosts, for_=seconds)
            begins = now + _NOTICE
            self._left += [(begins, Due(t, event)), (begins + seconds, Due(t, event, over=True))]
        self._left.sort(key=lambda one: one[0])
        count = sum(when <= now for when, _ in self._left)
        due, self._left = self._left[:count], self._left[count:]
        return [one for _, one in due]
