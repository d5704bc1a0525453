"""SPADE: each agent in its own process, over the XMPP server that comes with it.

Follows its documentation: usage (`spade run`, the server for agents of several processes) and
behaviours (a cyclic one that receives). A message has one receiver, so the plant sends the three
states to each agent in one message. Messages are text, with as many characters as ours have bytes.
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
    EchoSpec,
    RunPlant,
    answer,
    message,
    tick_of,
)

_DIGITS = 12
_TIMEOUT = 1.0  # [s] of one wait for a message


def main(spec: EchoSpec, run_plant: RunPlant) -> None:
    """Run the process that `spec` describes."""
    kind = {"plant": _Plant, GOAL: _Goal}.get(spec.role, _AgentRole)
    spade.run(_live(kind(spec, run_plant)))


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
    def __init__(self, spec: EchoSpec, run_plant: RunPlant) -> None:
        super().__init__(_name(spec.role), "secret", port=spec.port)
        self.spec, self.run_plant = spec, run_plant


class _Behaviour(CyclicBehaviour):  # type: ignore[misc]
    async def publish(self, role: str, data: bytes, **kind: str) -> None:
        await self.send(Message(to=_name(role), body=_letters(data), metadata=kind))

    async def latest_state(self) -> Any:
        """Wait for the newest state, ignoring goals; None if there is none in time."""
        found = None
        while found is None or self.mailbox_size():
            incoming = await self.receive(timeout=_TIMEOUT)
            if incoming is None:
                return None
            found = found if incoming.get_metadata("kind") == GOAL else incoming
        return found


class _Answer(_Behaviour):
    async def run(self) -> None:
        state = await self.latest_state()
        if state is not None:
            role = self.agent.spec.role
            await self.publish("plant", answer(role, _bytes(state.body)))


class _AgentRole(_Role):
    async def setup(self) -> None:
        self.add_behaviour(_Answer())


class _PublishGoal(_Behaviour):
    async def run(self) -> None:
        state = await self.latest_state()
        if state is not None:
            tick = tick_of(_bytes(state.body))
            for role in AGENTS:
                await self.publish(role, message(tick, GOAL_SIZE), kind=GOAL)
            await asyncio.sleep(GOAL_EVERY)


class _Goal(_Role):
    async def setup(self) -> None:
        self.add_behaviour(_PublishGoal())


class _Receive(_Behaviour):
    async def run(self) -> None:
        incoming = await self.receive(timeout=_TIMEOUT)
        if incoming is not None:
            arrived = time.monotonic()
            self.agent.arrivals.append(
                (self.agent.roles[incoming.sender.node], arrived, incoming.body)
            )


class _Publish(_Behaviour):
    async def run(self) -> None:
        state = message(await self.agent.due.get(), sum(STATES.values()))
        for role in ROLES[1:]:
            await self.publish(role, state)


class _Plant(_Role):
    """The plant; its clock runs in its own thread, independently of the messages."""

    async def setup(self) -> None:
        self.arrivals: deque[tuple[str, float, str]] = deque()
        self.due: asyncio.Queue[int] = asyncio.Queue()
        self.roles = {role.replace("/", "-"): role for role in AGENTS}
        self.add_behaviour(_Receive())
        self.add_behaviour(_Publish(), Template(to="nobody"))  # it receives no messages
        loop = asyncio.get_running_loop()

        def publish(tick: int) -> None:
            loop.call_soon_threadsafe(self.due.put_nowait, tick)

        def received() -> Iterator[tuple[str, float, bytes]]:
            for _ in range(len(self.arrivals)):
                role, arrived, letters = self.arrivals.popleft()
                yield role, arrived, _bytes(letters)

        self.clock = asyncio.create_task(
            asyncio.to_thread(self.run_plant, self.spec, publish, received)
        )
