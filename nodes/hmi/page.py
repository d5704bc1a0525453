"""The operator's page: a node of the robot that serves it, and drives the robot by what comes back.

Everything here is in one thread and one event loop, but for questions to the robot, which wait for
their answers in threads. Stopping has a thread of its own.
"""

import asyncio
import time
from concurrent.futures import ThreadPoolExecutor
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from nodes.hmi.address import Address, find_address, keep_address, new_address
from nodes.hmi.doorkeeper import Doorkeeper
from nodes.hmi.hello import meshes_of
from nodes.hmi.listening import LOOPBACK, DoorError, check_listen, tls_context
from runtime.config.kinds import Whole
from runtime.processes.node import Context, Node
from runtime.wire.mesh import ALL_BASES

if TYPE_CHECKING:
    from nodes.hmi.hub import Hub

Port = Annotated[int, Whole("8420", least=1, most=65535)]
_FIRST = ALL_BASES.stop  # the first port that no robot has for its processes
_SHARED = range(_FIRST + len(ALL_BASES), 32768)  # up to those that systems hand out
_FOLDER = Path(__file__).parent / "page"
_PERIOD = 0.05  # [s] from one state to the next
_IDLE = 0.2  # [s] the same while nobody looks
_TAKEN = 3.0  # [s] for which a revived page waits for the port that its predecessor had


class Page(Node):
    """Serves the page by which a person drives the robot, and an engineer watches it."""

    realtime = False  # a person waits longer than other programs delay it

    def __init__(
        self,
        *,
        port: Port | None = None,
        listen: str = LOOPBACK[0],
        names: tuple[str, ...] = (),
        certificate: Path | None = None,
        key: Path | None = None,
        language: Literal["en", "fr"] = "en",
    ) -> None:
        """Check the parameters; nothing is opened yet.

        Args:
            port: By default one that follows from the robot's ports, so that no other robot's page
                takes it while this one is not there.
            listen: The address that it listens at, of this computer; by default only programs on
                this computer reach it.
            names: Further names or addresses by which browsers call this computer.
            certificate: File with its TLS certificate (PEM), needed if others can reach it.
            key: File with the certificate's private key (PEM).
            language: Of the page, until a person chooses another.
        """
        if find_spec("websockets") is None:
            raise DoorError("class: the page needs a package more: pip install 'msma[web]'")
        check_listen(listen, names, certificate, key)
        self._port, self._listen, self._names = port, listen, names
        self._tls, self._language = tls_context(certificate, key), language

    def run(self, context: Context) -> None:
        """Serve the page until the process is to end."""
        asyncio.run(self._serve(context))

    async def _serve(self, context: Context) -> None:
        from nodes.hmi.hub import Hub  # with websockets, which `msma validate` does not need

        with (
            ThreadPoolExecutor(1, "halt") as halts,
            ThreadPoolExecutor(4, "request") as requests,
        ):
            hub = Hub(context, self._language, halts, requests)
            address = await self._open(context, hub)
            self.state = f"page at {address.origin}"
            try:
                await self._go_on(context, hub)
            finally:
                await hub.close()

    async def _open(self, context: Context, hub: "Hub") -> Address:
        """Listen at the port that was asked for, or else at its own or any that is free."""
        before = find_address(context.run)
        if self._port is not None:
            ports = [self._port]
        elif before is not None:
            ports = [before.port]
        else:
            ports = [own_port(context.deployment.port), *_SHARED]
        until = time.monotonic() + (_TAKEN if before is not None else 0.0)
        while True:
            for port in ports:
                address = self._address(port, before)
                names = tuple(dict.fromkeys((*self._own_names(), *self._names)))
                keeper = Doorkeeper(address, names, _FOLDER, meshes_of(context.robot.visuals))
                try:
                    await hub.open(keeper, self._listen, port, self._tls)
                except OSError as error:
                    why = str(error)
                    continue
                keep_address(context.run, address)
                return address
            if time.monotonic() > until:
                raise DoorError(f"port: {ports[0]} at {self._listen} cannot be had: {why}")
            await asyncio.sleep(0.1)

    def _own_names(self) -> tuple[str, ...]:
        if self._listen in LOOPBACK:
            return LOOPBACK
        return () if self._listen in ("0.0.0.0", "::") else (_bracketed(self._listen),)

    def _address(self, port: int, before: Address | None) -> Address:
        name = (*self._own_names(), *self._names)[0]
        origin = f"{'https' if self._tls else 'http'}://{name}:{port}"
        fresh = new_address(origin, port)
        if before is None:
            return fresh
        return fresh._replace(operator=before.operator, engineer=before.engineer)

    async def _go_on(self, context: Context, hub: "Hub") -> None:
        """Look at the robot and show it until the end."""
        while context.ending.reason is None:
            began = time.monotonic()
            hub.turn(began)
            self.work.add(time.monotonic() - began)
            await asyncio.sleep(_PERIOD if hub.is_watched else _IDLE)


def own_port(base: int) -> int:
    """Return the port of the page of the robot whose ports begin at `base`."""
    if base not in ALL_BASES:
        return _SHARED[base % len(_SHARED)]
    return _FIRST + ALL_BASES.index(base)


def _bracketed(address: str) -> str:
    """Return an address as it is written before a port."""
    return f"[{address}]" if ":" in address else address
