"""Serving the page: it listens at a port, and looks at the robot until the end.

Everything here is in one thread and one event loop, but for questions to the robot, which wait for
their answers in threads. Stopping has a thread of its own.
"""

import asyncio
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from nodes.hmi.address import Address, find_address, keep_address, new_address
from nodes.hmi.doorkeeper import Doorkeeper
from nodes.hmi.hello import meshes_of
from nodes.hmi.hub import Hub
from nodes.hmi.listening import LOOPBACK, DoorError, Listening
from runtime.processes.node import Context, Node
from runtime.wire.mesh import page_ports

_FOLDER = Path(__file__).parent / "page"
_PERIOD = 0.05  # [s] from one state to the next
_IDLE = 0.2  # [s] the same while nobody looks
_TAKEN = 3.0  # [s] for which a revived page waits for the port that its predecessor had


def serve(page: Node, context: Context, at: Listening, language: str) -> None:
    """Serve the page until the process is to end.

    Args:
        page: The node, for which this says where it is and how long its turns take.
        context: What its process has.
        at: Where it listens.
        language: Of the page, until a person chooses another.

    Raises:
        DoorError: If the port cannot be had.
    """
    asyncio.run(_serve(page, context, at, language))


async def _serve(page: Node, context: Context, at: Listening, language: str) -> None:
    with (
        ThreadPoolExecutor(1, "halt") as halts,
        ThreadPoolExecutor(4, "request") as requests,
    ):
        hub = Hub(context, language, halts, requests)
        address = await _open(context, hub, at)
        page.state = f"page at {address.origin}"
        try:
            await _go_on(page, context, hub)
        finally:
            await hub.close()


async def _open(context: Context, hub: Hub, at: Listening) -> Address:
    """Listen at the port that was asked for, or else at its own or any that is free."""
    before = find_address(context.run)
    if at.port is not None:
        ports = [at.port]
    elif before is not None:
        ports = [before.port]
    else:
        ports = [*page_ports(context.deployment.port)]
    until = time.monotonic() + (_TAKEN if before is not None else 0.0)
    names = tuple(dict.fromkeys((*_own_names(at), *at.names)))
    while True:
        for port in ports:
            address = _address(at, names[0], port, before)
            keeper = Doorkeeper(address, names, _FOLDER, meshes_of(context.robot.visuals))
            try:
                await hub.open(keeper, at.listen, port, at.tls)
            except OSError as error:
                why = str(error)
                continue
            keep_address(context.run, address)
            return address
        if time.monotonic() > until:
            raise DoorError(f"port: {ports[0]} at {at.listen} cannot be had: {why}")
        await asyncio.sleep(0.1)


def _own_names(at: Listening) -> tuple[str, ...]:
    if at.listen in LOOPBACK:
        return LOOPBACK
    return () if at.listen in ("0.0.0.0", "::") else (_bracketed(at.listen),)


def _address(at: Listening, name: str, port: int, before: Address | None) -> Address:
    origin = f"{'https' if at.tls else 'http'}://{name}:{port}"
    fresh = new_address(origin, port)
    if before is None:
        return fresh
    return fresh._replace(operator=before.operator, engineer=before.engineer)


async def _go_on(page: Node, context: Context, hub: Hub) -> None:
    """Look at the robot and show it until the end."""
    while context.ending.reason is None:
        began = time.monotonic()
        hub.turn(began)
        page.work.add(time.monotonic() - began)
        await asyncio.sleep(_PERIOD if hub.is_watched else _IDLE)


def _bracketed(address: str) -> str:
    """Return an address as it is written before a port."""
    return f"[{address}]" if ":" in address else address
