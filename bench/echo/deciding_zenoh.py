"""One process of the plain Zenoh echo that also decides: the limit of such a loop in Python.

The plant simulates and the agents decide, as often as MSMA's do, and all of them pack and unpack
the messages of the wire contract. Arbitration, percepts and logs are left out: the agents decide on
recorded percepts.
"""

from collections.abc import Callable, Sequence
from itertools import cycle
from typing import NamedTuple

from agents.agent import Agent, Array, Percepts
from bench.decisions import ArmRun, arm_run
from bench.echo.plain_zenoh import do_nothing, run_process
from bench.echo.workload import AGENTS, GOAL, ROLES, parse_args
from runtime.processes.timing import Cadence, apart
from runtime.wire.messages import (
    EndEffectorPose,
    JointCommand,
    JointStates,
    Message,
    PlatformCommand,
    PlatformPose,
)
from runtime.wire.packing import pack, unpack
from runtime.wire.topics import PLANT

_RECORDED = 200  # ticks
_UPRIGHT = (0.0, 0.0, 0.0, 1.0)


class TickWork(NamedTuple):
    """What a process does each tick, before and after it publishes its message."""

    before: Callable[[], object]
    after: Callable[[], object] = do_nothing

    def whole(self) -> None:
        """Do both."""
        self.before()
        self.after()


def tick_work(role: str, period: float) -> TickWork:
    """Return what the process of a role unpacks, decides and packs each tick of `period` [s]."""
    if role == GOAL:
        return TickWork(do_nothing)
    run = arm_run(_RECORDED, period)
    if role == PLANT:
        return _plant_of(run)
    agent = run.agents[role]
    cadence = Cadence(agent.rest, apart(ROLES.index(role)))
    return _agent_of(agent, run.percepts, cadence, period)


def _plant_of(run: ArmRun) -> TickWork:
    """Pack the state before publishing it; unpack the answers and simulate after."""
    commands = [_command(0.0, velocity) for velocity in (*run.commands.joints, run.commands.base)]
    answers = [(type(command), pack(command)) for command in commands]
    base, hand, joints = _states(run.percepts[-1])

    def write() -> None:
        for state in (base, hand, joints):
            pack(state)

    def simulate() -> None:
        for kind, data in answers:
            unpack(kind, data)
        run.plant.write(run.commands)
        run.plant.step()
        run.plant.read()

    assert len(answers) == len(AGENTS)
    return TickWork(write, simulate)


def _agent_of(
    agent: Agent, recorded: Sequence[Percepts], cadence: Cadence, period: float
) -> TickWork:
    """Answer with the last decision before publishing; decide after, as often as MSMA's agents."""
    states = [_states(percepts) for percepts in recorded]
    ticks = cycle(
        [(percepts, pack(base), pack(joints))
         for percepts, (base, _, joints) in zip(recorded, states, strict=True)]
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

    assert agent.rest > period  # or MSMA's agents would decide before they answer
    return TickWork(answer, decide)


def _states(percepts: Percepts) -> tuple[Message, ...]:
    """Return the messages of a plant from which these percepts come."""
    t, hand, joints, base, *_ = percepts
    assert hand is not None
    assert joints is not None
    assert base is not None
    return (
        PlatformPose(t, *base.tolist()),
        EndEffectorPose(t, tuple(hand.tolist()), _UPRIGHT),
        JointStates(t, tuple(joints.position.tolist()), tuple(joints.velocity.tolist())),
    )


def _command(t: float, velocity: Array | float) -> Message:
    """Return the command for a joint's velocity [rad/s] or a platform's two [m/s], [rad/s]."""
    if isinstance(velocity, float):
        return JointCommand(t, velocity)
    return PlatformCommand(t, float(velocity[0]), float(velocity[1]))


def main() -> None:
    """Run the process that the command line specifies."""
    spec = parse_args()
    run_process(spec, *tick_work(spec.role, 1 / spec.rate))


if __name__ == "__main__":
    main()
