"""One process of the plain echo that does our thinking as well: what a loop in Python can reach.

A plant that simulates and agents that decide, as often as ours do; each reads what it goes by, and
writes what it tells, as the wire contract has it. There is nothing around that: nobody is held
against who else speaks in that role, no percept is put together, nothing is logged. What they read
and think about was recorded.
"""

from collections.abc import Callable, Sequence
from itertools import cycle
from typing import NamedTuple

from agents.agent import Agent, Array, Percepts
from bench.decisions import ArmRun, arm_run
from bench.echo.plain_zenoh import be, nothing
from bench.echo.workload import AGENTS, GOAL, ROLES, part_of
from runtime.processes.timing import Cadence, apart
from runtime.wire.messages import (
    EndEffectorPose,
    JointCommand,
    JointStates,
    Message,
    PlatformCommand,
    PlatformPose,
    pack,
    unpack,
)
from runtime.wire.topics import PLANT

_RECORDED = 200  # ticks
_UPRIGHT = (0.0, 0.0, 0.0, 1.0)


class Thought(NamedTuple):
    """What a process does each tick: before it tells its message, and afterwards."""

    before: Callable[[], object]
    afterwards: Callable[[], object] = nothing

    def whole(self) -> None:
        """Do both."""
        self.before()
        self.afterwards()


def thought_of(role: str, period: float) -> Thought:
    """Return what the process of a role reads, thinks and writes each tick of `period` [s]."""
    if role == GOAL:
        return Thought(nothing)
    run = arm_run(_RECORDED, period)
    if role == PLANT:
        return _plant_of(run)
    agent = run.agents[role]
    cadence = Cadence(agent.rest, apart(ROLES.index(role)))
    return _agent_of(agent, run.seen, cadence, period)


def _plant_of(run: ArmRun) -> Thought:
    """Write the state as it is told, and before that, outside of the answer times, make it."""
    commands = [_command(0.0, velocity) for velocity in (*run.commands.joints, run.commands.base)]
    answers = [(type(command), pack(command)) for command in commands]
    base, hand, joints = _states(run.seen[-1])

    def write() -> None:
        for told in (base, hand, joints):
            pack(told)

    def simulate() -> None:
        for kind, data in answers:
            unpack(kind, data)
        run.plant.write(run.commands)
        run.plant.step()
        run.plant.read()

    assert len(answers) == len(AGENTS)
    return Thought(write, simulate)


def _agent_of(agent: Agent, seen: Sequence[Percepts], cadence: Cadence, period: float) -> Thought:
    """Read what calls for an answer, and decide as often as our agents do: once that is told."""
    states = [_states(percepts) for percepts in seen]
    ticks = cycle(
        [(percepts, pack(base), pack(joints))
         for percepts, (base, _, joints) in zip(seen, states, strict=True)]
    )  # fmt: skip
    sees_base = "base" in agent.sees
    percepts, base, _ = next(ticks)
    decided = agent.decide(percepts)

    def answer() -> None:
        nonlocal percepts, base
        percepts, base, joints = next(ticks)
        unpack(JointStates, joints)
        assert decided is not None
        pack(_command(percepts.t, decided))

    def decide() -> None:
        nonlocal decided
        if cadence.due(percepts.t):
            if sees_base:
                unpack(PlatformPose, base)
            decided = agent.decide(percepts)

    assert agent.rest > period  # or ours would decide before they answer
    return Thought(answer, decide)


def _states(percepts: Percepts) -> tuple[Message, ...]:
    """Return what a plant tells of what is perceived."""
    t, hand, joints, base, *_ = percepts
    assert hand is not None
    assert joints is not None
    assert base is not None
    return (
        PlatformPose(t, *base.tolist()),
        EndEffectorPose(t, tuple(hand.tolist()), _UPRIGHT),
        JointStates(t, tuple(joints.position.tolist()), tuple(joints.velocity.tolist())),
    )


def _command(t: float, wanted: Array | float) -> Message:
    """Return what an agent tells that wants a joint's velocity [rad/s], or a platform's two."""
    if isinstance(wanted, float):
        return JointCommand(t, wanted)
    return PlatformCommand(t, float(wanted[0]), float(wanted[1]))


def main() -> None:
    """Be the part that the command line names."""
    part = part_of()
    be(part, *thought_of(part.role, 1 / part.rate))


if __name__ == "__main__":
    main()
