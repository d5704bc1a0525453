"""Poses: arms of all kinds move their hands to random poses and after moving ones; long chains."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import numpy as np

from agents.agent import Agent, Array
from plant.robot import Robot, RobotError
from studies.baselines.central import as_agents
from studies.baselines.pose_ik import DampedLeastSquares, ForwardLeastSquares, PoseController
from studies.cases.drawn import TUNING
from studies.cases.kind import BackwardsToo
from studies.cases.posed import (
    AROUND,
    CHAIN_DURATION,
    CHAIN_NEAR,
    DURATION,
    LAST,
    NEAR,
    PERIOD,
    SOURCES,
    TASKS,
    TURNED,
    UR5,
    Posed,
    Source,
    Task,
    arrived,
    chain,
    follow,
    moving,
    play,
    posed,
    settled,
    team,
)
from studies.held_out import interval
from studies.study import Claim, Findings, Progress, Row, Study, check_draw, share

COUNT = 200
"""Arms of each robot and task, and moving poses."""
MOVING = ((0.06, 1e-3, math.radians(0.5)), (0.001, 1e-4, None))
"""Period [s], and bars on the medians of the largest errors [m], [rad]."""
CHAINS = (5, 24, 48, 64, 128)
"""Numbers of joints."""
GOALS = 30
"""For each chain."""
LIBRARIES = ("pink", "pinocchio", "daqp")
"""What the comparison with pink takes."""


class Side(NamedTuple):
    """A controller beside MSMA.

    Attributes:
        name: For people.
        make: Its class; None if it cannot run.
        informed: Whether it is told which joints are locked.
    """

    name: str
    make: Callable[..., PoseController] | None
    informed: bool


@dataclass(frozen=True)
class PosesFound(Findings):
    """Results of the study.

    Attributes:
        shares: For each task, who and how many of how many.
    """

    shares: dict[str, list[tuple[str, tuple[int, int]]]]


class Poses(Study[PosesFound]):
    """Random poses that can be reached, poses that move, and long chains."""

    name = "poses"
    title = "Poses: random ones, with a joint locked, moving ones, and chains of up to 128 joints"

    def __init__(self, seed: int = 100) -> None:
        """Draw all cases from a seed; those of `TUNING` are for tuning.

        Raises:
            StudyError: It is negative.
        """
        check_draw(seed)
        self._seed = seed

    def measure(self, size: float, progress: Progress) -> PosesFound:
        """Run all robots and tasks with a share `size` of the cases, and chains as time allows."""
        rows: list[Row] = []
        shares: dict[str, list[tuple[str, tuple[int, int]]]] = {task.name: [] for task in TASKS}
        each = sum(1 + len(sides(task)) for task in TASKS)
        progress.begin(len(SOURCES) * each + len(MOVING) + 2 * sum(map(_parts, CHAINS)))
        for source in SOURCES:
            for task in TASKS:
                for row, who, counts in self._reaching(source, task, _count(COUNT, size), progress):
                    rows.append(progress.row(row))
                    if counts is not None:
                        shares[task.name].append((who, counts))
        for row in self._following(_count(COUNT, size), progress):
            rows.append(progress.row(row))
        for joints in CHAINS:
            for late in (False, True):
                progress.step(f"chain of {joints} joints", _parts(joints))
                rows.append(progress.row(self._chain(joints, late, size)))
        locked = [counts for who, counts in shares[TASKS[-1].name] if who.endswith("MSMA")]
        found = [f"{100 * count / of:.1f}" for count, of in locked]
        claims = (
            Claim(
                "fully fault tolerant if goal is reachable (3.2.3)",
                f"random poses with one joint locked, by robot: {', '.join(found)} %",
            ),
        )
        return PosesFound(tuple(rows), claims, self._notes(), shares)

    def draw(self, found: PosesFound, folder: Path) -> tuple[Path, ...]:
        """Draw the shares of each task with their intervals."""
        from studies.drawing.shares import shares

        return tuple(
            shares([who for who, _ in each], [counts for _, counts in each], task.bar,
                   folder / f"poses-{number}.png")
            for number, task in enumerate(TASKS, 1)
            if (each := found.shares[task.name])
        )  # fmt: skip

    def _reaching(
        self, source: Source, task: Task, count: int, progress: Progress
    ) -> Iterator[tuple[Row, str, tuple[int, int] | None]]:
        """Yield a row for MSMA and for each controller beside it, who it is, and how many."""
        required = f"{100 * task.bar:g} %"
        name = f"{source.name}, {task.name}"
        try:
            robot = source.load()
        except RobotError as error:
            progress.step(name, 1 + len(sides(task)))
            yield Row(f"{name}: MSMA", required, f"left out: {error}"), name, None
            return
        arms = posed(robot, task, count, self._seed)
        drives = robot.drive is not None
        progress.step(name, 0.5 if drives else 1.0)
        since = self._settled(arms, team(robot, PERIOD, self._seed))
        good, of = int(np.isfinite(since).sum()), len(since)
        met = bool(good >= task.bar * of)
        yield Row(f"{name}: MSMA", required, _said(since), met), f"{source.name}, MSMA", (good, of)
        if drives:
            too = "MSMA, backwards too"
            progress.step(f"{name}, {too}", 0.5)
            since = self._settled(arms, team(robot, PERIOD, self._seed, BackwardsToo))
            counts = int(np.isfinite(since).sum()), len(since)
            yield Row(f"{name}: {too}", "", _said(since)), f"{source.name}, {too}", counts
        for side in sides(task, drives):
            progress.step(f"{name}, {side.name}", len(sides(task)) / len(sides(task, drives)))
            what = f"{name}: {side.name}"
            if side.make is None:
                yield Row(what, "", f"left out: needs {', '.join(_missing())}"), what, None
                continue
            since = self._beside(side, arms)
            counts = int(np.isfinite(since).sum()), len(since)
            yield Row(what, "", _said(since)), f"{source.name}, {side.name}", counts

    def _beside(self, side: Side, arms: Posed) -> Array:
        assert side.make is not None
        locked = arms.locked if side.informed else None
        controller = side.make(arms.robot, PERIOD, locked=locked)
        return self._settled(arms, as_agents(controller, arms.robot))

    def _settled(self, arms: Posed, agents: Mapping[str, Agent]) -> Array:
        return settled(arms, play(arms, agents, self._seed))

    def _following(self, count: int, progress: Progress) -> Iterator[Row]:
        """Yield the rows of moving poses."""
        robot: Robot | None = None
        try:
            robot, reason = UR5.load(), ""
        except RobotError as error:
            reason = f"left out: {error}"
        arms = None if robot is None else moving(robot, count, self._seed)
        if arms is not None and not len(arms.q):
            reason = f"none of {count} that the oracle follows"
        for period, most, turned in MOVING:
            what = f"{UR5.name}, moving pose, {1e3 * period:g} ms: median of largest errors"
            bar = f"at most {1e3 * most:g} mm"
            bar += "" if turned is None else f", {math.degrees(turned):g} deg"
            progress.step(what)
            if robot is None or arms is None or reason:
                yield Row(what, bar, reason)
                continue
            agents = team(robot, period, self._seed)
            distance, angle, _ = follow(arms, agents, period, self._seed)
            middle, turn = float(np.median(distance)), float(np.median(angle))
            yield Row(
                what, bar,
                f"{1e3 * middle:.3f} mm, {np.degrees(turn):.3f} deg; of nine in ten "
                f"{1e3 * np.quantile(distance, 0.9):.2f} mm, "
                f"{np.degrees(np.quantile(angle, 0.9)):.2f} deg; {len(arms.q)} of {count} followed "
                "by the oracle",
                middle <= most and (turned is None or turn <= turned),
            )  # fmt: skip

    def _chain(self, joints: int, late: bool, size: float) -> Row:
        what = f"chain of {joints} joints{', a period late' if late else ''}"
        what += f": within {1e3 * CHAIN_NEAR:g} mm"
        if joints > max(CHAINS[-1] * np.sqrt(size), CHAINS[0]):
            return Row(what, "all", "left out at this size")
        since = arrived(chain(joints, late, _count(GOALS, size), self._seed))
        return Row(what, "all", _said(since), bool(np.isfinite(since).all()))

    def _notes(self) -> tuple[str, ...]:
        kind = "is one" if self._seed in TUNING else "is not one"
        return (
            f"Seed {self._seed}, which {kind} of those that laws and baselines are tuned on.",
            f"A hand has its pose if it stays within {1e3 * NEAR:g} mm and {np.degrees(TURNED):g} "
            f"deg to the end of {DURATION:g} s, for {LAST:g} s at least; starts and goals are "
            "random postures. A joint is locked where it is, in the goal's posture too. ARPH "
            f"drives: in the goal's posture up to {AROUND:g} m away. In brackets the 95 % interval "
            "(Wilson).",
            "Damped least squares and pink are central: studies/baselines/pose_ik.py. Both make "
            "the same random moves at goals that stand as MSMA's joints. They drive ARPH backwards "
            "too unless it says otherwise; MSMA's platform does not, as its sensors look ahead, "
            "unless it says so.",
            "Moving poses: those that damped least squares follows at 60 ms without a joint beyond "
            "a third of its top speed; errors count from 2 s on.",
            f"Chains are planar, 1 m long and given {CHAIN_DURATION:g} s at 60 ms; at a size below "
            "1 the longer ones are left out.",
        )


def sides(task: Task, drives: bool = False) -> tuple[Side, ...]:
    """Return the controllers beside MSMA, told which joint is locked, if one is, and not told.

    Beside a platform that `drives` there is one that goes forward only, as MSMA's does.
    """
    pink: Callable[..., PoseController] | None = None
    if not _missing():
        from studies.baselines.pose_pink import Pink

        pink = Pink
    makers: dict[str, Callable[..., PoseController] | None] = {
        "central damped least squares": DampedLeastSquares,
        "pink": pink,
    }
    if drives:
        makers["central damped least squares, forward only"] = ForwardLeastSquares
    if not task.locked:
        return tuple(Side(name, make, False) for name, make in makers.items())
    return tuple(
        Side(f"{name}, {'told' if informed else 'not told'}", make, informed)
        for name, make in makers.items()
        for informed in (False, True)
    )


def _missing() -> list[str]:
    return [name for name in LIBRARIES if find_spec(name) is None]


def _count(full: int, size: float) -> int:
    return max(round(full * size), 2)


def _parts(joints: int) -> float:
    """Return how long a chain takes, in units of a robot's task: each joint looks at all others."""
    return (joints / 24) ** 2


def _said(since: Array) -> str:
    """Return how many have their goal, and when, as text."""
    good = np.isfinite(since)
    if not good.any():
        return share(0, len(since))
    times = since[good]
    return (
        f"{interval(int(good.sum()), len(since))}; after {np.median(times):.1f} s, "
        f"nine in ten of these {np.quantile(times, 0.9):.1f} s"
    )
