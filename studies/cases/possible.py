"""Which cases of a mobile arm can be done: those for which a planner finds a motion.

See `studies/mobile_reach.py`. Where nothing is locked, and for bolted arms, whose goals are drawn
from postures, every case counts as one that can be done.
"""

from dataclasses import replace

import numpy as np

from agents.agent import Array
from plant.robot import Robot
from studies.batch_faults import BatchFaults
from studies.cases.goals import Goals, rows
from studies.cases.kind import Kind, play, team
from studies.feasible_plans import Since, earliest
from studies.mobile import ARPH
from studies.mobile_reach import Bools

SPARE = 3.0
"""How long a motion has to be on the path before the error counts [s]."""
AT_ONCE = 4
"""Cells planned for at once: more need more than 1 GB of memory."""


def possible(kind: Kind, spare: float = SPARE) -> Bools:
    """Return for which cases (B,) a planner that knows the faults finds a motion in time.

    Args:
        kind: The cases.
        spare: How long the motion has to be on the path before the error counts [s].
    """
    each = kind.each
    dead = each.strength[:, :3] == 0.0
    answer: Bools = (np.isnan(kind.locks) & ~dead).all(axis=1) | (kind.robot.drive is None)
    if answer.all():
        return answer
    whole = replace(kind, each=BatchFaults.none(kind.robot, len(kind)))
    trace = play(whole, team(kind.robot), until=float(each.since.max()))
    last = kind.duration - kind.judged - spare
    for since in np.unique(each.since[~answer]):
        tick = int(np.argmin(np.abs(trace.t - since)))
        q = kind.q if since == 0 else trace.q[tick]
        base = kind.base if since == 0 else trace.base[tick]
        locks = np.where(dead, q[:, :3], kind.locks)
        free = np.isnan(locks)
        broken = ~answer & (each.since == since)
        for pattern in np.unique(free[broken], axis=0):
            which = np.nonzero(broken & (free == pattern).all(axis=1))[0]
            for some in np.array_split(which, -(-len(which) // AT_ONCE)):
                start = Since(float(since), q[some, :3], base[some] / [kind.size, kind.size, 1.0])
                goals = _smaller(rows(kind.goals, some), kind.size)
                robot = slower(kind.robot, kind.size)
                when = earliest(robot, locks[some], goals, start, kind.duration)
                answer[some] = when <= last
    return answer


def slower(robot: Robot, size: float) -> Robot:
    """Return a robot of ARPH's size that moves as one `size` times as large does, seen in scale."""
    if size == 1.0 or robot.drive is None:
        return robot
    drive = replace(
        robot.drive,
        max_linear=robot.drive.max_linear / size,
        max_linear_acceleration=robot.drive.max_linear_acceleration / size,
    )
    return replace(ARPH, joints=robot.joints, drive=drive)


def _smaller(goals: Goals, size: float) -> Goals:
    def at(t: float) -> tuple[Array, Array]:
        position, velocity = goals(t)
        return position / size, velocity / size

    return at
