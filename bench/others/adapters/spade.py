"""SPADE: each agent in a process of its own, over the XMPP server that comes with it.

Of its documentation: usage (`spade run`, the server for agents of several processes) and
behaviours (a cyclic one that receives). A message has one receiver, so the plant sends each of
them the three states in one; and it is text, of as many letters as our messages have bytes.
"""

import asyncio
import time
from collections import deque
from collections.abc import Iterator
from typing import Any

import spade
from spade.agent import Agent
from spade.behaviour import CyclicBehaviour
from spade.message import Message
from spade.template import Template

from bench.echo.workload import (
    AGENTS,
    GOAL,
    GOAL_EVERY,
    GOAL_SIZE,
    ROLES,
    STATES,
    BePlant,
    Part,
    answer,
    message,
    tick_of,
)

_DIGITS = 12
_PATIENCE = 1.0  # [s] for a message, before asking again


def main(part: Part, be_plant: BePlant) -> None:
    """Be the part."""
    kind = {"plant": _Plant, GOAL: _Goal}.get(part.role, _Mover)
    spade.run(_live(kind(part, be_plant)))


async def _live(agent: Any) -> None:
    await agent.start()
    await asyncio.Event().wait()


def _name(role: str) -> str:
    return f"{role.replace('/', '-')}@localhost"


def _letters(data: bytes) -> str:
    return f"{tick_of(data):0{_DIGITS}d}".ljust(len(data), ".")


def _bytes(letters: str) -> bytes:
    return message(int(letters[:_DIGITS]), len(letters))


class _Role(Agent):  # type: ignore[misc]
    def __init__(self, part: Part, be_plant: BePlant) -> None:
        super().__init__(_name(part.role), "secret", port=part.port)
        self.part, self.be_plant = part, be_plant


class _Behaviour(CyclicBehaviour):  # type: ignore[misc]
    async def tell(self, role: str, data: bytes, **kind: str) -> None:
        await self.send(Message(to=_name(role), body=_letters(data), metadata=kind))

    async def newest(self) -> Any:
        """Wait for the newest state, letting goals pass; None if nothing comes."""
        found = None
        while found is None or self.mailbox_size():
            came = await self.receive(timeout=_PATIENCE)
            if came is None:
                return None
            found = found if came.get_metadata("kind") == GOAL else came
        return found


class _Answer(_Behaviour):
    async def run(self) -> None:
        state = await self.newest()
        if state is not None:
            role = self.agent.part.role
            await self.tell("plant", answer(role, _bytes(state.body)))


class _Mover(_Role):
    async def setup(self) -> None:
        self.add_behaviour(_Answer())


class _TellGoal(_Behaviour):
    async def run(self) -> None:
        state = await self.newest()
        if state is not None:
            tick = tick_of(_bytes(state.body))
            for role in AGENTS:
                await self.tell(role, message(tick, GOAL_SIZE), kind=GOAL)
            await asyncio.sleep(GOAL_EVERY)


class _Goal(_Role):
    async def setup(self) -> None:
        self.add_behaviour(_TellGoal())


class _Hear(_Behaviour):
    async def run(self) -> None:
        came = await self.receive(timeout=_PATIENCE)
        if came is not None:
            arrived = time.monotonic()
            self.agent.came.append((self.agent.roles[came.sender.node], arrived, came.body))


class _Tell(_Behaviour):
    async def run(self) -> None:
        state = message(await self.agent.due.get(), sum(STATES.values()))
        for role in ROLES[1:]:
            await self.tell(role, state)


class _Plant(_Role):
    """Beats in a thread of its own, for it must not wait for messages, nor they for it."""

    async def setup(self) -> None:
        self.came: deque[tuple[str, float, str]] = deque()
        self.due: asyncio.Queue[int] = asyncio.Queue()
        self.roles = {role.replace("/", "-"): role for role in AGENTS}
        self.add_behaviour(_Hear())
        self.add_behaviour(_Tell(), Template(to="nobody"))  # without, it would get all messages
        loop = asyncio.get_running_loop()

        def tell(tick: int) -> None:
            loop.call_soon_threadsafe(self.due.put_nowait, tick)

        def heard() -> Iterator[tuple[str, float, bytes]]:
            for _ in range(len(self.came)):
                role, arrived, letters = self.came.popleft()
                yield role, arrived, _bytes(letters)

        self.beating = asyncio.create_task(asyncio.to_thread(self.be_plant, self.part, tell, heard))
