"""Which cases of a mobile arm can be done: those for which a planner finds a motion.

See `studies/mobile_reach.py`. Where nothing is locked, and for bolted arms, whose goals are drawn
from postures, every case counts as one that can be done.
"""

from dataclasses import replace

import numpy as np

from agents.agent import Array
from agents.bends import CORNER
from plant.robot import Robot
from studies.batch_faults import BatchFaults
from studies.cases.goals import Goals, Rows, rows
from studies.cases.kind import Kind, play, team
from studies.feasible_plans import Since, earliest
from studies.lockstep import Trace
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
                start = Since(float(since), q[some, :3], base[some])
                answer[some] = _earliest(kind, some, locks[some], start) <= last
    return answer


def answerable(kind: Kind, trace: Trace, which: Bools) -> Bools:
    """Return for which cases (B,) a planner finds a motion that knows of no corner before it comes.

    It plans from where a run had brought the robot when its goal last began or ceased to move, or
    turned by more than `CORNER`. It has to be on the path when the error begins to count, and 2 s
    before the end (see `earliest`). Cases without a corner after their faults can be answered.

    Args:
        kind: The cases; joints may be locked, and none is dead.
        trace: Of the run.
        which: (B,) those of broken arms to plan for; the others count as answerable.
    """
    answer = np.ones(len(kind), dtype=bool)
    going = np.stack([np.broadcast_to(kind.goals(float(t))[1], (len(kind), 3)) for t in trace.t])
    speed = np.linalg.norm(going, axis=-1)
    along = (going[1:] * going[:-1]).sum(axis=-1)
    corners = along < np.cos(CORNER) * speed[1:] * speed[:-1]
    corners |= (speed[1:] > 0) != (speed[:-1] > 0)
    corners &= trace.t[1:, None] > kind.each.since
    for row in np.flatnonzero(which & corners.any(axis=0)):
        tick, some = 1 + int(np.flatnonzero(corners[:, row])[-1]), np.array([row])
        start = Since(float(trace.t[tick]), trace.q[tick, some, :3], trace.base[tick, some])
        when = _earliest(kind, some, kind.locks[some], start)
        answer[row] = when[0] <= kind.duration - kind.judged
    return answer


def _earliest(kind: Kind, some: Rows, locks: Array, start: Since) -> Array:
    """Return when cases `some` (C,) are on their paths to stay [s], see `earliest`."""
    start = start._replace(base=start.base / [kind.size, kind.size, 1.0])
    goals = _smaller(rows(kind.goals, some), kind.size)
    return earliest(slower(kind.robot, kind.size), locks, goals, start, kind.duration)


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
