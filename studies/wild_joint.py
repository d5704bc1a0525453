"""One motor turns at random, whatever it is told: what accuracy remains, and what could at best."""

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
from studies.study import Claim, Findings, Row, Study, Watch, share

SHARES = (0.05, 0.2, 0.5)
"""Of full speed, to which the wild motor turns."""
PERCEPTIONS = ("blackboard", "localiser")
AREA = Ring(np.zeros(2), np.array(0.2), np.array(0.5))
"""Of the goals."""
STEPS, LAST = 400, 200
"""Of 0.1 s: in all, and those at the end that count."""


@dataclass(frozen=True)
class Found(Findings):
    """What the picture needs.

    Attributes:
        shares: Of full speed.
        remaining: By perception, (shares, n): the root of the mean squared distance [m].
        floor: (shares, n) what could remain at best [m].
    """

    shares: tuple[float, ...]
    remaining: dict[str, Array]
    floor: Array


class WildJoint(Study[Found]):
    """One of five motors turns at random."""

    name = "wild-joint"
    title = "One motor turns at random"

    def measure(self, size: float, watch: Watch) -> Found:
        """Let each joint run wild at each speed, with both perceptions."""
        robot = load("planar5")
        watch.expect(len(SHARES) * len(PERCEPTIONS) * robot.n)
        count = max(round(40 * size), 4)
        remaining = {p: np.empty((len(SHARES), robot.n)) for p in PERCEPTIONS}
        floor = np.zeros((len(SHARES), robot.n))
        came: dict[tuple[str, float], list[Array]] = {}
        for perception in PERCEPTIONS:
            for row, part in enumerate(SHARES):
                for joint in range(robot.n):
                    watch.at(f"joint {joint + 1} at {100 * part:g} %, {perception}")
                    history, lever = one(robot, joint, part, perception, count)
                    remaining[perception][row, joint] = np.sqrt((history[-LAST:] ** 2).mean())
                    floor[row, joint] += at_best(robot, part, lever) / len(PERCEPTIONS)
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
        """Draw what remains, by the wild joint."""
        from studies.drawing.planar_studies import wild_joint

        file = folder / "wild-joint.png"
        return (wild_joint(found.shares, found.remaining, found.floor, file),)


def one(robot: Robot, joint: int, part: float, perception: str, count: int) -> tuple[Array, Array]:
    """Return distances (K, B) [m], and the wild joint's levers (B,) [m] at the end.

    Goals are where the other joints can bring the hand whatever the wild one does.
    """
    q, place = anywhere(robot, np.random.default_rng([20, joint]), count, 0.0, AREA)
    wild = (Fault(f"joint/{joint + 1}", "runaway", part),)
    reached = reach(robot, q, place, steps=STEPS, seed=joint, faults=wild, perception=perception)
    arm = Kinematics(robot).forward(reached.q)
    lever = np.sqrt(((arm.tip - arm.points[:, joint]) ** 2).sum(axis=-1))
    return reached.history, lever


def at_best(robot: Robot, part: float, lever: Array) -> float:
    """Return the root of the mean squared distance that nobody can avoid [m].

    The wild motor takes a new speed, even between plus and minus m, at random moments, each
    T_r = 0.5 s in the mean. A change by d shows only a period T later, when the hand is d T lever
    off; from then on the speed is known and all of it can be made good in the next period. So of
    T / T_r of the moments, E[(d T lever)^2] = 2/3 m^2 T^2 lever^2 remains.
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
            rows.append(
                Row(f"{100 * part:g} % of full speed, {perception}", "",
                    f"rms {1e3 * np.sqrt((table[index] ** 2).mean()):.1f} mm (at best "
                    f"{1e3 * np.sqrt((floor[index] ** 2).mean()):.1f} mm); worst joint "
                    f"{1e3 * table[index].max():.1f} mm; came within 5 mm at some time: "
                    f"{share(ok.sum(), ok.size)}")
            )  # fmt: skip
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
              f"exactly there: at 5, 20, 50 % of full speed there remain (rms) {'; '.join(said)}; "
              f"at best {best} mm"),
    )  # fmt: skip


NOTES = (
    "The wild motor takes a new random speed every 0.5 s in the mean; 0.1 s a step. What remains "
    "is taken over the last 20 s of 40 s.",
    "At best: nobody can know of a change of speed before it shows, one period later; the formula "
    "is in studies/wild_joint.py. It leaves out that the motor takes time to change its speed.",
)
