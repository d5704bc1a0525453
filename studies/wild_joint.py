"""One motor turns at random whatever its command: the remaining error, and its lower bound."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from agents.agent import Array
from plant.effects import RUNAWAY_INTERVAL
from plant.faults import Fault
from plant.kinematics import Kinematics
from plant.robot import Robot
from plant.urdf import load
from studies.arm_batch import NEAR, PERIOD, reach
from studies.planar_reach import Ring, anywhere
from studies.study import Claim, Findings, Progress, Row, Study, share

SHARES = (0.05, 0.2, 0.5)
"""Shares of full speed up to which the random motor turns."""
PERCEPTIONS = ("blackboard", "localiser")
CAME = (1.0, 1.0, 0.95)
"""Bars on the share of hands that come within 5 mm, for each of `SHARES`."""
TIMES = {"blackboard": 5.0, "localiser": 10.0}
"""Bars on the remaining error, as multiples of its lower bound; without a model it takes longer."""
AREA = Ring(np.zeros(2), np.array(0.2), np.array(0.5))
"""Area of the goals."""
STEPS, LAST = 400, 200
"""Steps of 0.1 s: in total, and the last ones, which are evaluated."""


@dataclass(frozen=True)
class Found(Findings):
    """Results of the study.

    Attributes:
        shares: Shares of full speed.
        remaining: By perception, (shares, n) rms distance [m].
        floor: (shares, n) lower bound of that distance [m].
    """

    shares: tuple[float, ...]
    remaining: dict[str, Array]
    floor: Array


class WildJoint(Study[Found]):
    """One of five motors turns at random."""

    name = "wild-joint"
    title = "One motor turns at random"

    def measure(self, size: float, progress: Progress) -> Found:
        """Let each motor turn at random at each speed, with both perceptions."""
        robot = load("planar5")
        progress.begin(len(SHARES) * len(PERCEPTIONS) * robot.n)
        count = max(round(40 * size), 4)
        remaining = {p: np.empty((len(SHARES), robot.n)) for p in PERCEPTIONS}
        floor = np.zeros((len(SHARES), robot.n))
        came: dict[tuple[str, float], list[Array]] = {}
        for perception in PERCEPTIONS:
            for row, part in enumerate(SHARES):
                for joint in range(robot.n):
                    progress.step(f"joint {joint + 1} at {100 * part:g} %, {perception}")
                    history, lever = one(robot, joint, part, perception, count)
                    remaining[perception][row, joint] = np.sqrt((history[-LAST:] ** 2).mean())
                    floor[row, joint] += lower_bound(robot, part, lever) / len(PERCEPTIONS)
                    came.setdefault((perception, part), []).append(history.min(axis=0) < NEAR)
        return Found(
            rows=_rows(remaining, floor, came),
            claims=_claims(remaining, floor, came),
            notes=NOTES,
            shares=SHARES,
            remaining=remaining,
            floor=floor,
        )

    def draw(self, found: Found, folder: Path) -> tuple[Path, ...]:
        """Draw the remaining error by joint."""
        from studies.drawing.planar_studies import wild_joint

        file = folder / "wild-joint.png"
        return (wild_joint(found.shares, found.remaining, found.floor, file),)


def one(robot: Robot, joint: int, part: float, perception: str, count: int) -> tuple[Array, Array]:
    """Return distances (K, B) [m], and the random joint's lever arms (B,) [m] at the end.

    The other joints can reach the goals whatever the random one does.
    """
    q, goals = anywhere(robot, np.random.default_rng([20, joint]), count, 0.0, AREA)
    wild = (Fault(f"joint/{joint + 1}", "runaway", part),)
    reached = reach(robot, q, goals, steps=STEPS, seed=joint, faults=wild, perception=perception)
    arm = Kinematics(robot).forward(reached.q)
    lever = np.sqrt(((arm.tip - arm.points[:, joint]) ** 2).sum(axis=-1))
    return reached.history, lever


def lower_bound(robot: Robot, part: float, lever: Array) -> float:
    """Return the rms distance that no controller can avoid [m].

    The motor changes to a new speed, uniform between -m and m, at random times T_r = 0.5 s apart on
    average. A change by d is observable only one period T later, when the hand is off by d T lever;
    from then on the speed is known and can be fully compensated in the next period. So for a share
    T / T_r of the time, E[(d T lever)^2] = 2/3 m^2 T^2 lever^2 remains.
    """
    most = part * float(robot.max_speed[0])
    rate = PERIOD / RUNAWAY_INTERVAL
    return float(np.sqrt(rate * 2.0 / 3.0 * (most * PERIOD) ** 2 * (lever**2).mean()))


def _rows(
    remaining: dict[str, Array], floor: Array, came: dict[tuple[str, float], list[Array]]
) -> tuple[Row, ...]:
    rows = []
    for perception, table in remaining.items():
        for index, part in enumerate(SHARES):
            ok = np.concatenate(came[perception, part])
            name = f"{100 * part:g} % of full speed, {perception}"
            rms, least = (float(np.sqrt((each**2).mean())) for each in (table[index], floor[index]))
            rows += [
                Row(f"within 5 mm at some time, {name}", f"{100 * CAME[index]:g} %",
                    share(ok.sum(), ok.size), bool(ok.mean() >= CAME[index])),
                Row(f"rms error, {name}",
                    f"at most {TIMES[perception]:g} times the lower bound",
                    f"{1e3 * rms:.1f} mm (lower bound {1e3 * least:.1f} mm); worst joint "
                    f"{1e3 * table[index].max():.1f} mm", rms <= TIMES[perception] * least),
            ]  # fmt: skip
    return tuple(rows)


def _claims(
    remaining: dict[str, Array], floor: Array, came: dict[tuple[str, float], list[Array]]
) -> tuple[Claim, ...]:
    said = []
    for perception, table in remaining.items():
        each = [f"{1e3 * np.sqrt((row**2).mean()):.1f}" for row in table]
        said.append(f"{perception} {', '.join(each)} mm")
    best = ", ".join(f"{1e3 * np.sqrt((row**2).mean()):.1f}" for row in floor)
    all_came = np.concatenate([np.concatenate(each) for each in came.values()])
    return (
        Claim('"even if a motor is randomly moving because of noises or control system fault, the '
              'system will reach the goal" (3.2.3)',
              f"{share(all_came.sum(), all_came.size)} hands came within 5 mm; they cannot stay "
              f"exactly there: at 5, 20, 50 % of full speed the rms error is {'; '.join(said)}; "
              f"its lower bound is {best} mm"),
    )  # fmt: skip


NOTES = (
    "The motor takes a new random speed every 0.5 s on average; a step is 0.1 s. The remaining "
    "error is that of the last 20 s of 40 s.",
    "Lower bound: no controller can know of a change of speed before it is observable, one period "
    "later; the formula is in studies/wild_joint.py. It neglects the time that the motor takes to "
    "change its speed.",
)
