"""Cyclone DDS for Python: best effort, keeping the last sample of each key.

Of its documentation: the entity `DataReader` (`take_iter`, which waits on a wait set) and the
policies of quality of service. The messages are arrays of bytes of our sizes.
"""

import threading
import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from cyclonedds.core import Policy, Qos
from cyclonedds.domain import DomainParticipant
from cyclonedds.idl import IdlStruct
from cyclonedds.idl.annotations import key
from cyclonedds.idl.types import sequence, uint8
from cyclonedds.pub import DataWriter
from cyclonedds.sub import DataReader
from cyclonedds.topic import Topic

from bench.echo.workload import (
    AGENTS,
    GOAL,
    JOINT_STATES,
    STATES,
    BePlant,
    Part,
    be_agent,
    be_goal,
    message,
)

_LATEST = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(1))


@dataclass
class Told(IdlStruct, typename="Told"):  # type: ignore[misc, call-arg]
    """A state or a goal."""

    data: sequence[uint8]


@dataclass
class Command(IdlStruct, typename="Command"):  # type: ignore[misc, call-arg]
    """A command; each agent's is an instance of its own."""

    agent: uint8
    key("agent")
    data: sequence[uint8]


def main(part: Part, be_plant: BePlant) -> None:
    """Be the part."""
    participant = DomainParticipant(part.port)
    commands = Topic(participant, "command", Command)
    told = {name: Topic(participant, name.replace("/", "_"), Told) for name in (*STATES, GOAL)}
    if part.role == "plant":
        _plant(participant, part, be_plant, told, commands)
        return
    board = DataReader(participant, told.pop(JOINT_STATES), qos=_LATEST)
    states = board.take_iter()
    if part.role == GOAL:
        out = DataWriter(participant, told[GOAL], qos=_LATEST)
        be_goal(lambda: bytes(next(states).data), lambda data: out.write(Told(data)))
    else:
        out = DataWriter(participant, commands, qos=_LATEST)
        others = [DataReader(participant, topic, qos=_LATEST) for topic in told.values()]
        number = AGENTS.index(part.role)

        def newest() -> bytes:
            state = bytes(next(states).data)
            for other in others:
                other.take()
            return state

        be_agent(part, newest, lambda data: out.write(Command(number, data)))


def _plant(
    participant: Any, part: Part, be_plant: BePlant, told: dict[str, Any], commands: Any
) -> None:
    out = {name: DataWriter(participant, told[name], qos=_LATEST) for name in STATES}
    back = DataReader(participant, commands, qos=_LATEST)
    came: deque[tuple[str, float, bytes]] = deque()

    def listen() -> None:
        for sample in back.take_iter():
            came.append((AGENTS[sample.agent], time.monotonic(), bytes(sample.data)))

    threading.Thread(target=listen, daemon=True).start()

    def tell(tick: int) -> None:
        for name, size in STATES.items():
            out[name].write(Told(message(tick, size)))

    def heard() -> Iterator[tuple[str, float, bytes]]:
        for _ in range(len(came)):
            yield came.popleft()

    be_plant(part, tell, heard)
