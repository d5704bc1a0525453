"""One encoder stuck, lost or biased while its motor works, with each perception."""

from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np

from agents.agent import Array
from plant.faults import Fault
from plant.robot import Robot
from plant.urdf import load
from studies.arm_batch import NEAR, reach
from studies.planar_reach import anywhere
from studies.study import Claim, Findings, Progress, Row, Study, share

Perception = Literal["blackboard", "localiser", "auto"]
PERCEPTIONS: tuple[Perception, ...] = ("blackboard", "localiser", "auto")
FAULTS = {"stuck": None, "lost": None, "biased": float(np.radians(10.0))}
STEPS = 600
"""Steps of 0.1 s."""
BARS = {"localiser": 0.99, "auto": 0.99}
"""Bars on the share of goals that are reached; the blackboard, which needs encoders, has none."""


@dataclass(frozen=True)
class Found(Findings):
    """Results of the study: distances at the end by fault and perception [m]."""

    ends: dict[tuple[str, str], Array]


class EncoderFaults(Study[Found]):
    """One of five encoders is faulty from the start."""

    name = "encoder-faults"
    title = "One encoder stuck, lost or biased while its motor works"

    def measure(self, size: float, progress: Progress) -> Found:
        """Run each fault of each encoder with each perception."""
        robot = load("planar5")
        progress.begin(len(FAULTS) * len(PERCEPTIONS) * robot.n)
        count = max(round(60 * size), 4)
        ends: dict[tuple[str, str], Array] = {}
        for fault in FAULTS:
            for perception in PERCEPTIONS:
                parts = []
                for joint in range(robot.n):
                    progress.step(f"encoder {joint + 1} {fault}, {perception}")
                    parts.append(one(robot, joint, fault, perception, count))
                ends[fault, perception] = np.concatenate(parts)
        return Found(
            rows=tuple(_row(*key, end) for key, end in ends.items()),
            claims=_claims(ends),
            notes=NOTES,
            ends=ends,
        )

    def draw(self, found: Found, folder: Path) -> tuple[Path, ...]:
        """Draw the distances at the end."""
        from studies.drawing.planar_studies import encoder_faults

        return (encoder_faults(found.ends, folder / "encoder-faults.png"),)


def one(robot: Robot, joint: int, fault: str, perception: Perception, count: int) -> Array:
    """Return the worst distances in the last second (B,) [m] with one faulty encoder."""
    q, goals = anywhere(robot, np.random.default_rng([33, joint]), count, 0.05)
    reached = reach(
        robot, q, goals, steps=STEPS, seed=joint,
        faults=(Fault(f"encoder/{joint + 1}", fault, FAULTS[fault]),), enough=NEAR / 20,
        perception=perception,
    )  # fmt: skip
    return reached.settled


def _row(fault: str, perception: str, end: Array) -> Row:
    ok = end < NEAR
    bar = BARS.get(perception)
    return Row(f"within 5 mm, encoder {fault}, {perception}",
               "" if bar is None else f"{100 * bar:g} %",
               f"{share(ok.sum(), ok.size)}; median {1e3 * np.median(end):.3g} mm, "
               f"worst {1e3 * end.max():.3g} mm",
               None if bar is None else bool(ok.mean() >= bar))  # fmt: skip


def _claims(ends: dict[tuple[str, str], Array]) -> tuple[Claim, ...]:
    def said(perception: str) -> str:
        return ", ".join(
            f"{fault} {100 * (ends[fault, perception] < NEAR).mean():.1f} %" for fault in FAULTS
        )

    return (
        Claim('"If a blackboard is used [...] joint encoders must not be out of order even if '
              'motor is." (3.2.3)',
              f"confirmed. Within 5 mm with the blackboard: {said('blackboard')}"),
        Claim('"In this simulation we can use only the end effector position knowledge" (3.2.2): '
              '"joint encoder out of order or not"',
              f"with the localiser: {said('localiser')}; with `auto`, which uses the blackboard "
              f"while it agrees with the localiser: {said('auto')}"),
    )  # fmt: skip


NOTES = (
    "The fault is present from the start, in each of the five encoders in turn; a bias is 10 deg. "
    "With an encoder lost there are no joint states, so with the blackboard nothing moves.",
    "Goals are at least 5 cm inside the reachable area; each run lasts 60 s.",
)
