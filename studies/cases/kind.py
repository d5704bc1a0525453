"""A kind of cases: robots that differ in start, faults and goal, run as one batch, and judged."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from agents.agent import Agent, Array, Body, Goal, Percepts
from agents.joint import HoldAgent, JointAgent
from agents.platform import PlatformAgent
from plant.plant import Commands, Setup
from plant.robot import Robot
from studies.batch_faults import BatchFaults, BatchPlant
from studies.cases import goals as goals_of
from studies.cases.goals import Goals, Rows
from studies.lockstep import Trace, decide_all, true_motion
from studies.mobile import ARPH, BASE, BEARING, MOVING, PERIOD, POSTURE
from studies.mobile_reach import Bools
from studies.platform_measures import path_roughness, turned_about

MID = 8.0
"""When joints break in mid-path [s]."""
GOOD = 0.003
"""Error within which a hand has its goal [m]: the paper's."""
DISTURBED = 6.0
"""When a platform is pushed, or one goal is false [s]."""
PUSH = 0.5
"""How long a platform is pushed [s]."""


@dataclass(frozen=True, eq=False)
class Kind:
    """B cases that are run at once.

    Attributes:
        name: What they have in common.
        q: (B, n) joint angles at the start [rad].
        base: (B, 3) platform poses at the start [m], [rad].
        each: The faults of each.
        goals: Their goals.
        duration: How long each runs [s].
        judged: The last part of the run, in which the error must stay within tolerance [s].
        robot: The robot; with a drive, one like ARPH.
        size: Its lengths, as multiples of ARPH's.
        pushed: (B,) turning speed forced on the platform for `PUSH` [rad/s].
        false: (B, 3) error of the one goal at `DISTURBED` [m].
    """

    name: str
    q: Array
    base: Array
    each: BatchFaults
    goals: Goals
    duration: float
    judged: float = 1.0
    robot: Robot = ARPH
    size: float = 1.0
    pushed: Array | None = None
    false: Array | None = None

    def __len__(self) -> int:
        """How many cases."""
        return len(self.q)

    @property
    def locks(self) -> Array:
        """(B, 3) angles at which joints 1 to 3 are locked [rad]; NaN for free joints."""
        return self.each.locked[:, :3]

    def part(self, rows: Rows) -> "Kind":
        """Return some of the cases."""
        each = self.each
        return replace(
            self,
            q=self.q[rows],
            base=self.base[rows],
            each=BatchFaults(
                each.locked[rows], each.strength[rows], each.platform[rows], each.since[rows]
            ),
            goals=goals_of.rows(self.goals, rows),
            pushed=None if self.pushed is None else self.pushed[rows],
            false=None if self.false is None else self.false[rows],
        )


def locked(
    name: str, locks: Array, since: Array | float, goals: Goals, duration: float, *,
    judged: float = 1.0, robot: Robot = ARPH, size: float = 1.0, platform: float = 1.0,
) -> Kind:  # fmt: skip
    """Return cases that start in the posture of Table 1.

    Args:
        name: What they have in common.
        locks: (B, 3) angles at which joints 1 to 3 are locked [rad]; NaN for free joints. A joint
            that is locked from the start, starts there.
        since: When they are, one or (B,) [s].
        goals: Their goals.
        duration: [s].
        judged: See `Kind`.
        robot: See `Kind`.
        size: See `Kind`.
        platform: The share of its commanded speeds that the platform makes.
    """
    each = BatchFaults.none(robot, len(locks))
    each.locked[:, :3] = locks
    each.since[:] = since
    each.platform[:] = platform
    q = np.tile(POSTURE, (len(locks), 1))
    from_start = ~np.isnan(locks) & (each.since == 0)[:, None]
    q[:, :3] = np.where(from_start, locks, q[:, :3])
    base = np.tile(BASE * [size, size, 1.0], (len(locks), 1))
    return Kind(name, q, base, each, goals, duration, judged, robot, size)


class BackwardsToo(PlatformAgent):
    """A platform that drives backwards too, to see what it costs MSMA's that it never does."""

    least = np.array([-1.0, -1.0])


def team(
    robot: Robot = ARPH, platform: type[Agent] = PlatformAgent, period: float = PERIOD
) -> dict[str, Agent]:
    """Return the agents of a robot by role: of a mobile one, as in deploy/arph.yaml.

    Args:
        robot: One like ARPH, or a bolted arm, all of whose joints take part.
        platform: Class of the platform's agent.
        period: Control period [s].
    """
    agents: dict[str, Agent] = {}
    for joint in range(robot.n):
        body = Body(robot, joint, period, [0, joint])
        moves = joint in MOVING or robot.drive is None
        agents[f"joint/{joint + 1}"] = JointAgent(body) if moves else HoldAgent(body)
    if robot.drive is not None:
        body = Body(robot, None, period, [0, robot.n])
        agents["platform"] = platform(body, bearing=BEARING)  # type: ignore[call-arg]
    return agents


def play(
    kind: Kind, agents: Mapping[str, Agent], period: float = PERIOD, until: float | None = None
) -> Trace:
    """Run all cases of a kind as one batch, in lockstep.

    Args:
        kind: The cases.
        agents: By role.
        period: Control period [s]; the trace has a tick each 60 ms.
        until: When to stop instead of at the end [s].
    """
    setup = Setup(kind.robot, kind.q, kind.base, period=period, seed=[0, 1000])
    robots = BatchPlant(setup, kind.each)
    ticks: list[tuple[Array, ...]] = []
    every = max(round(PERIOD / period), 1)
    for tick in range(round((kind.duration if until is None else until) / period) + 1):
        t, q, qd, base, base_velocity, hand, _ = map(np.asarray, true_motion(robots))
        position, velocity = kind.goals(float(t))
        if tick % every == 0:
            ticks.append((t, hand, position, q, qd, base, base_velocity))
        sent = position
        if kind.false is not None and abs(t - DISTURBED) < period / 2:
            sent = position + kind.false
        goal = Goal(sent, velocity, float(t), float(t) + 10.0)
        commands = decide_all(agents, Percepts.of(robots.read(), goal), q.shape)
        if kind.pushed is not None and DISTURBED <= t < DISTURBED + PUSH:
            drive = np.array(commands.base)
            drive[:, 1] = np.where(kind.pushed != 0, kind.pushed, drive[:, 1])
            commands = Commands(commands.joints, drive)
        robots.write(commands)
        robots.step()
    return Trace(*(np.stack(column) for column in zip(*ticks, strict=True)))


class Judgement(NamedTuple):
    """How B cases went, (B,) each.

    Attributes:
        final: Largest error of the part that is judged [m].
        median: Median error of the last fifth of the run [m].
        settled: From when on the error stays within `GOOD` to the end [s]; infinite if never.
        turned: How far the platform turned, both ways [rad].
        late: How far it turned in the last 5 s [rad].
        jerk: Rms jerk of the platform's middle [m/s3].
        elbow: Least angle of joint 3 from straight [rad].
    """

    final: Array
    median: Array
    settled: Array
    turned: Array
    late: Array
    jerk: Array
    elbow: Array

    @property
    def success(self) -> Bools:
        """Whether the error stays within `GOOD` from some time on to the end."""
        good: Bools = self.final <= GOOD
        return good


def judged(kind: Kind, trace: Trace) -> Judgement:
    """Judge all cases of a kind by their trace."""
    error, t = trace.error, trace.t
    bad = error > GOOD
    after = len(error) - np.argmax(bad[::-1], axis=0)  # the tick after the last bad one
    settled = np.where(bad.any(axis=0), t[np.minimum(after, len(t) - 1)], 0.0)
    return Judgement(
        error[t >= t[-1] - kind.judged - 1e-9].max(axis=0),
        np.median(error[-len(error) // 5 :], axis=0),
        np.where(bad[-1], np.inf, settled),
        turned_about(trace.base),
        turned_about(trace.base[t >= t[-1] - 5.0]),
        path_roughness(trace.base, PERIOD),
        np.abs(trace.q[..., 2]).min(axis=0),
    )
