"""Figures 4 and 5 of the paper: a planar arm unfolds and folds, with MSMA and with Duhaut's MD."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from agents.agent import Agent, Array, Body, Goal
from agents.joint import JointAgent
from plant.kinematic import KinematicPlant
from plant.plant import Setup
from plant.urdf import load
from studies.arm_batch import PERIOD
from studies.baselines import md
from studies.lockstep import run
from studies.motion_measures import (
    Motion,
    crossing,
    gini,
    least_bend,
    log_dimensionless_jerk,
    spectral_arc_length,
    summed_motion,
)
from studies.planar_reach import flat
from studies.study import Claim, Findings, Progress, Row, Study, share

LINK = 0.2
"""Length of each link of planar5 [m]."""
STEPS = 300
STEP = float(np.radians(5.0))
"""Largest turn of a joint in a step, with either method [rad]."""
NEAR = 0.005
"""Distance to the goal at which a motion ends [m]."""
FOLDED = np.radians([90.0, -150.0, 145.0, -140.0, 135.0])
STRETCHED = np.radians([70.0, 12.0, -10.0, 12.0, -8.0])
FAR, CLOSE = np.array([0.75, 0.5]), np.array([0.3, 0.12])
"""Goals [m] similar to those in the paper's figures, which give no numbers."""


@dataclass(frozen=True)
class Found(Findings):
    """Results of the study: the paper's case and random others, each with MSMA and with MD."""

    goal: Array
    paper: tuple[Motion, Motion]
    others: tuple[tuple[Motion, Motion], ...]


class Unfold(Study[Found]):
    """From folded to stretched."""

    name = "unfold"
    title = "Unfolding a five-joint arm with MSMA and with MD (figure 4)"
    start, goal, folding = FOLDED, FAR, False

    def measure(self, size: float, progress: Progress) -> Found:
        """Run the paper's case and similar random cases with both methods."""
        progress.begin(2)
        progress.step("the paper's case", 0.2)
        (paper,) = both(self.start[None], self.goal[None])
        progress.step("random starts and goals", 1.8)
        q, goal = draw_cases(max(round(100 * size), 4), self.folding)
        others = tuple(both(q, goal))
        return Found(
            rows=self._rows(paper, others),
            claims=self._claims(paper, others),
            notes=NOTES,
            goal=self.goal,
            paper=paper,
            others=others,
        )

    def draw(self, found: Found, folder: Path) -> tuple[Path, ...]:
        """Draw three stages of the motion, the measures, and an animation."""
        from studies.drawing.unfolding import moving, stages

        return (
            stages(found.goal, found.paper, found.others, self.title, folder / f"{self.name}.png"),
            moving(found.goal, found.paper, folder / f"{self.name}.gif"),
        )

    def _rows(
        self, paper: tuple[Motion, Motion], others: tuple[tuple[Motion, Motion], ...]
    ) -> tuple[Row, ...]:
        evener = sum(ours.uneven < theirs.uneven for ours, theirs in others)
        count = len(others)
        crossed = [sum(pair[i].crossed > 0 for pair in others) for i in (0, 1)]
        reached = [sum(pair[i].reached for pair in others) for i in (0, 1)]
        no_crossing = self.folding
        pair = "MSMA {}, MD {}".format
        ours, theirs = paper
        return (
            Row("random cases in which MSMA distributes the motion more evenly (lower Gini index)",
                "at least 95 %", share(evener, count), evener >= 0.95 * count),
            Row("random cases: Gini index, median", "", pair(
                *(f"{np.median([each[i].uneven for each in others]):.2f}" for i in (0, 1)))),
            Row("the paper's case: steps in which links cross, MSMA",
                "none" if no_crossing else "", str(ours.crossed),
                ours.crossed == 0 if no_crossing else None),
            Row("the paper's case: steps in which links cross, MD", "", str(theirs.crossed)),
            Row("random cases in which links cross at some time", "", pair(*crossed)),
            Row("random cases that reached the goal within 5 mm", "", pair(*reached)),
            Row("the paper's case: Gini index", "", pair(
                f"{ours.uneven:.2f}", f"{theirs.uneven:.2f}")),
            Row("the paper's case: least angle from straight", "", pair(
                *(f"{np.degrees(each.bend):.1f} deg" for each in paper))),
            Row("random cases: least angle from straight, median", "", pair(
                *(f"{_straight(others, i):.1f} deg" for i in (0, 1)))),
            Row("random cases: log dimensionless jerk of the hand, median", "", pair(
                *(f"{np.median([each[i].jerk for each in others]):.2f}" for i in (0, 1)))),
            Row("random cases: SPARC of the hand, median", "", pair(
                *(f"{np.median([each[i].arc for each in others]):.2f}" for i in (0, 1)))),
        )  # fmt: skip

    def _claims(
        self, paper: tuple[Motion, Motion], others: tuple[tuple[Motion, Motion], ...]
    ) -> tuple[Claim, ...]:
        evener = sum(ours.uneven < theirs.uneven for ours, theirs in others)
        ours, theirs = paper
        moved = [100 * _shares(each.q) for each in paper]
        listed = ["/".join(f"{part:.0f}" for part in each) for each in moved]
        return (
            Claim('"The MSMA system unfolds all links at the same time"; MD "starting with the end '
                  'effector one" (3.2.1)',
                  f"share of the motion by joint, base first, in %: MSMA {listed[0]}, "
                  f"MD {listed[1]}; MSMA is more even in {share(evener, len(others))} of cases"),
            Claim('"the arm configuration stays far from singular positions" (3.2.3)',
                  f"least angle from straight in the paper's case: MSMA "
                  f"{np.degrees(ours.bend):.1f} deg, MD {np.degrees(theirs.bend):.1f} deg"),
        )  # fmt: skip


class Fold(Unfold):
    """From stretched to folded."""

    name = "fold"
    title = "Folding a five-joint arm with MSMA and with MD (figure 5)"
    start, goal, folding = STRETCHED, CLOSE, True

    def _claims(
        self, paper: tuple[Motion, Motion], others: tuple[tuple[Motion, Motion], ...]
    ) -> tuple[Claim, ...]:
        evener = sum(ours.uneven < theirs.uneven for ours, theirs in others)
        crossed = [share(sum(pair[i].crossed > 0 for pair in others), len(others)) for i in (0, 1)]
        return (
            Claim('"a more distributed movement between joints in the case of the MSMA approach" '
                  "(3.2.1, folding)",
                  f"MSMA is more even in {share(evener, len(others))} of the random cases"),
            Claim('"There is no collision between links." (3.2.1)',
                  f"in the paper's case links cross in {paper[0].crossed} steps with MSMA and "
                  f"{paper[1].crossed} with MD; in the random cases they cross in {crossed[0]} "
                  f"with MSMA and {crossed[1]} with MD: nothing in the method prevents it"),
            Claim('"the arm configuration stays far from singular positions" (3.2.3)',
                  f"not when it folds: joints change the sign of their angle, so in the paper's "
                  f"case the least angle from straight is {np.degrees(paper[0].bend):.1f} deg with "
                  f"MSMA and {np.degrees(paper[1].bend):.1f} deg with MD; median of the random "
                  f"cases {_straight(others, 0):.1f} and {_straight(others, 1):.1f} deg"),
        )  # fmt: skip


def _straight(pairs: tuple[tuple[Motion, Motion], ...], method: int) -> float:
    """Return the median of the least angles from straight [deg], of MSMA (0) or MD (1)."""
    return float(np.degrees(np.median([pair[method].bend for pair in pairs])))


def draw_cases(count: int, folding: bool) -> tuple[Array, Array]:
    """Draw random starts (count, 5) [rad] and goals (count, 2) [m].

    Angles are uniform, and goals are uniform within 95 cm of the base. A case is one of folding if
    its goal is nearer to the base than the hand at the start. No start has crossing links.
    """
    rng = np.random.default_rng([45, folding])
    starts: list[Array] = []
    goals: list[Array] = []
    while len(starts) < count:
        q = rng.uniform(-np.pi, np.pi, 5)
        radius, angle = 0.95 * np.sqrt(rng.random()), rng.uniform(-np.pi, np.pi)
        points = md.arm_points(q, LINK)
        if (np.hypot(*points[-1]) > radius) == folding and not crossing(points):
            starts.append(q)
            goals.append(radius * np.array([np.cos(angle), np.sin(angle)]))
    return np.stack(starts), np.stack(goals)


def both(q: Array, goal: Array) -> list[tuple[Motion, Motion]]:
    """Move arms at q (B, 5) [rad] to goals (B, 2) [m] with MSMA and with MD."""
    robot = load("planar5")
    agents: dict[str, Agent] = {
        f"joint/{i + 1}": JointAgent(Body(robot, i, PERIOD, i), perception="blackboard")
        for i in range(robot.n)
    }
    position = flat(goal)
    piece = Goal(position, np.zeros_like(position), 0.0, 0.0)
    trace = run(
        KinematicPlant(Setup(robot, q, period=PERIOD)), agents, lambda _: piece, STEPS * PERIOD
    )
    theirs = md.follow(q, goal, length=LINK, step=STEP, steps=STEPS)
    return [(motion(trace.q[:, i], goal[i]), motion(theirs[:, i], goal[i])) for i in range(len(q))]


def motion(q: Array, goal: Array) -> Motion:
    """Measure a motion q (K, 5) [rad] up to one step after the hand is within 5 mm."""
    points = md.arm_points(q, LINK)
    near = np.hypot(*(points[:, -1] - goal).T) < NEAR
    end = int(near.argmax()) + 2 if near.any() else len(q)
    q, points = q[:end], points[:end]
    hand = points[:, -1]
    speed = np.hypot(*np.diff(hand, axis=0).T) / PERIOD
    return Motion(
        q,
        hand,
        bool(near.any()),
        float(gini(summed_motion(q))),
        log_dimensionless_jerk(speed, PERIOD),
        spectral_arc_length(speed, PERIOD),
        float(least_bend(q)),
        int(crossing(points).sum()),
    )


def _shares(q: Array) -> Array:
    moved = summed_motion(q)
    shares: Array = moved / max(float(moved.sum()), 1e-12)
    return shares


NOTES = (
    "Both methods turn a joint by at most 5 deg in a step of 0.1 s; the joints of MD turn in "
    "proportion towards the result of its pass. A motion ends when the hand is within 5 mm.",
    "The paper gives no numbers for its figures; start and goal are similar to them. A random case "
    "has any start without crossing links and any goal within 95 cm of the base; it is one of "
    "unfolding if the goal is farther from the base than the hand at the start.",
    "Links cross if their centre lines intersect; links have no width.",
)
