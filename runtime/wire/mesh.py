"""Where the processes of a robot listen and to whom they connect: a mesh that any one can leave.

Each process has a slot with a port of its own, at the address of its host, and connects to the
lower slots only. Of every two the higher one connects, so they never end up with half a connection
each; and whichever process ends, a new one connects to lower slots, and higher ones connect to it.
"""

from typing import NamedTuple
from zlib import crc32

SLOTS = 128
"""Ports of a robot: one for each process."""
FIRST_COPY = 96
"""First slot of copies of agents; each role has a slot of its own below it."""
_FIRST_PORT, _ROBOTS = 7600, 190  # ports up to 31919, below those that systems hand out

ALL_BASES = range(_FIRST_PORT, _FIRST_PORT + SLOTS * _ROBOTS, SLOTS)
"""The first port of every robot that follows from a name."""


def port_base(robot: str) -> int:
    """Return the first port of a robot."""
    return ALL_BASES[crc32(robot.encode()) % _ROBOTS]


_FIRST_PAGE = ALL_BASES.stop  # the first port that no robot has for its processes
_SHARED_BY_PAGES = range(_FIRST_PAGE + len(ALL_BASES), 32768)  # up to those that systems hand out


def page_ports(base: int) -> tuple[int, ...]:
    """Return the ports for the page of the robot whose ports begin at `base`, its own one first.

    No other page has that one if the robot's ports follow from its name.
    """
    if base in ALL_BASES:
        own = _FIRST_PAGE + ALL_BASES.index(base)
    else:
        own = _SHARED_BY_PAGES[base % len(_SHARED_BY_PAGES)]
    return (own, *_SHARED_BY_PAGES)


LOOPBACK = "127.0.0.1"


class Address(NamedTuple):
    """A host's address or name on the network, and a port of it."""

    host: str
    port: int

    def __str__(self) -> str:
        return f"[{self.host}]:{self.port}" if ":" in self.host else f"{self.host}:{self.port}"


class Endpoints(NamedTuple):
    """Where a process listens, and to whom it connects.

    Attributes:
        listen: Where it listens; port 0 for any port.
        rarely: Further addresses, tried less often because most of them are not in use.
        elsewhere: Number of roles on other hosts.
        routers: Zenoh routers; if there are any, it connects to one of these only.
    """

    listen: Address
    dials: tuple[Address, ...]
    rarely: tuple[Address, ...] = ()
    elsewhere: int = 0
    routers: tuple[str, ...] = ()

    @property
    def dialled_ports(self) -> frozenset[int]:
        """The ports of the processes or routers that it connects to."""
        if self.routers:
            return frozenset(int(router.rpartition(":")[2]) for router in self.routers)
        return frozenset(there.port for there in (*self.dials, *self.rarely))


class Mesh(NamedTuple):
    """The addresses of a robot's processes.

    Attributes:
        base: The first of the robot's ports, the same on every host.
        homes: Address of each role's host, in the order of slots.
        addresses: Those of all hosts, where copies may run.
        routers: Addresses and ports of Zenoh routers that carry all traffic instead.
    """

    base: int
    homes: tuple[str, ...]
    addresses: tuple[str, ...]
    routers: tuple[str, ...] = ()

    def endpoints(self, slot: int) -> Endpoints:
        """Return the endpoints of a role's process."""
        return self._place(self.homes[slot], slot, slot)

    def copy_endpoints(self, slot: int, home: str) -> Endpoints:
        """Return the endpoints of a copy in one of the slots for copies of the host `home`.

        A slot's port is there on each host, so of two copies in one slot the host decides.
        """
        before = self.addresses[: self.addresses.index(home)]
        rarely = (*self._copies(slot), *(Address(address, self.base + slot) for address in before))
        return self._place(home, slot, rarely=rarely)

    def visitor(self) -> Endpoints:
        """Return the endpoints of a tool, which dials all roles and copies and is dialled by none.

        Dialling 128 slots of which 10 answer costs it 0.1 s at the start and 2 % of a core, so it
        is worth knowing how many roles there are.
        """
        visitor = self._place(LOOPBACK, 0, rarely=self._copies(SLOTS))
        return visitor._replace(listen=Address(LOOPBACK, 0))

    def _place(
        self, home: str, slot: int, below: int | None = None, rarely: tuple[Address, ...] = ()
    ) -> Endpoints:
        """Return what listens in a slot and connects to all roles, or those below a slot."""
        roles = enumerate(self.homes[:below])
        dials = tuple(Address(other, self.base + number) for number, other in roles)
        elsewhere = sum(other != home for other in self.homes)
        return Endpoints(Address(home, self.base + slot), dials, rarely, elsewhere, self.routers)

    def _copies(self, below: int) -> tuple[Address, ...]:
        slots = range(FIRST_COPY, below)
        return tuple(Address(home, self.base + slot) for slot in slots for home in self.addresses)


def on_loopback(base: int, roles: int = FIRST_COPY) -> Mesh:
    """Return the mesh of a robot that is all on this machine, with up to so many roles."""
    return Mesh(base, (LOOPBACK,) * roles, (LOOPBACK,))
