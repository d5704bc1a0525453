"""Cyclone DDS for Python: best effort, keeping the last sample of each key.

Follows its documentation of `DataReader` (`take_iter`, which waits on a wait set) and of the
quality of service policies. The messages are byte arrays of the sizes of ours.
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
    EchoSpec,
    RunPlant,
    message,
    run_agent,
    run_goal_source,
)

_LATEST = Qos(Policy.Reliability.BestEffort, Policy.History.KeepLast(1))


@dataclass
class Payload(IdlStruct, typename="Payload"):  # type: ignore[misc, call-arg]
    """A state or a goal."""

    data: sequence[uint8]


@dataclass
class Command(IdlStruct, typename="Command"):  # type: ignore[misc, call-arg]
    """A command; each agent has its own instance."""

    agent: uint8
    key("agent")
    data: sequence[uint8]


def main(spec: EchoSpec, run_plant: RunPlant) -> None:
    """Run the process that `spec` describes."""
    participant = DomainParticipant(spec.port)
    commands = Topic(participant, "command", Command)
    topics = {name: Topic(participant, name.replace("/", "_"), Payload) for name in (*STATES, GOAL)}
    if spec.role == "plant":
        _plant(participant, spec, run_plant, topics, commands)
        return
    board = DataReader(participant, topics.pop(JOINT_STATES), qos=_LATEST)
    states = board.take_iter()
    if spec.role == GOAL:
        out = DataWriter(participant, topics[GOAL], qos=_LATEST)
        run_goal_source(lambda: bytes(next(states).data), lambda data: out.write(Payload(data)))
    else:
        out = DataWriter(participant, commands, qos=_LATEST)
        others = [DataReader(participant, topic, qos=_LATEST) for topic in topics.values()]
        number = AGENTS.index(spec.role)

        def latest_state() -> bytes:
            state = bytes(next(states).data)
            for other in others:
                other.take()
            return state

        run_agent(spec, latest_state, lambda data: out.write(Command(number, data)))


def _plant(
    participant: Any, spec: EchoSpec, run_plant: RunPlant, topics: dict[str, Any], commands: Any
) -> None:
    out = {name: DataWriter(participant, topics[name], qos=_LATEST) for name in STATES}
    back = DataReader(participant, commands, qos=_LATEST)
    arrivals: deque[tuple[str, float, bytes]] = deque()

    def listen() -> None:
        for sample in back.take_iter():
            arrivals.append((AGENTS[sample.agent], time.monotonic(), bytes(sample.data)))

    threading.Thread(target=listen, daemon=True).start()

    def publish(tick: int) -> None:
        for name, size in STATES.items():
            out[name].write(Payload(message(tick, size)))

    def received() -> Iterator[tuple[str, float, bytes]]:
        for _ in range(len(arrivals)):
            yield arrivals.popleft()

    run_plant(spec, publish, received)
