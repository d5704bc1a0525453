"""Figure 8 of the paper: the platform's motion with MSMA and with MIM."""

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

import numpy as np

from agents.agent import Agent, Array
from plant.kinematics import Kinematics
from studies.baselines.central import as_agents
from studies.baselines.mim import Mim
from studies.baselines.tuning import TRIALS, TUNED, tuned
from studies.lockstep import Trace, run
from studies.mobile import ARPH, DURATION, PERIOD, msma, plant, task
from studies.platform_measures import (
    cusps,
    heading_to_arm,
    path_length,
    path_roughness,
    reversal,
    turned_about,
)
from studies.study import Claim, Findings, Progress, Row, Study

SETTLED = 2.0
"""Time from which the error counts [s]."""
FINE = 0.001
"""The shorter control period [s]."""


class Drive(NamedTuple):
    """One controller's run of the paper's task, and its measures.

    Attributes:
        name: Name of the controller, with its period.
        trace: The run, a tick each 60 ms.
        error: Largest error after `SETTLED`, and before [m].
        length: Length of the platform's path [m].
        reversal: Distance in reverse [m].
        cusps: Number of cusps.
        turn: Total turn of the heading in both directions [rad].
        roughness: Rms jerk of the platform's middle [m/s3].
        lined_up: Mean and final angle between heading and arm [rad].
        elbow: Least and final angle of the elbow from straight [rad].
    """

    name: str
    trace: Trace
    error: tuple[float, float]
    length: float
    reversal: float
    cusps: int
    turn: float
    roughness: float
    lined_up: tuple[float, float]
    elbow: tuple[float, float]


@dataclass(frozen=True)
class PathFound(Findings):
    """Results of the study: MSMA, MIM, tuned MIM at 60 ms, and MSMA at 1 ms."""

    drives: tuple[Drive, ...]


class PlatformPath(Study[PathFound]):
    """MSMA and MIM on the paper's task."""

    name = "platform-path"
    title = "The platform's path with MSMA and with MIM (figure 8)"

    def measure(self, size: float, progress: Progress) -> PathFound:
        """Run all at 60 ms, and MSMA at 1 ms for a share `size` of the task."""
        progress.begin(26)
        progress.step("60 ms")
        coarse = drive("MSMA, 60 ms", msma(), PERIOD, DURATION)
        mim = drive("MIM, 60 ms", as_agents(Mim(ARPH), ARPH), PERIOD, DURATION)
        best = drive("tuned MIM, 60 ms", as_agents(tuned("MIM"), ARPH), PERIOD, DURATION)
        progress.step("1 ms", 25)
        duration = max(round(DURATION * size / PERIOD), 50) * PERIOD
        fine = drive("MSMA, 1 ms", msma(FINE), FINE, duration)
        return PathFound(
            rows=_rows(coarse, mim, best, fine),
            claims=_claims(coarse, mim),
            notes=(
                "Table 1 of the paper, 400 steps of 60 ms. A cusp is a change between forward and "
                "reverse; the angle to the arm is that between the heading and the direction from "
                "the column to the hand.",
                "MIM maximises the arm's manipulability sqrt(det(Ja Ja^T)), K = 4 1/s, k = 4, with "
                "weights 0.3 for driving and 1 for turning; the same robot, limits and period.",
                "Tuned MIM has an integral term too, and the best of "
                f"{TRIALS} random choices of its parameters on this very task "
                f"(`python -m studies.baselines.tuning`): {TUNED['MIM']}.",
                _better(coarse, best),
            ),
            drives=(coarse, mim, best, fine),
        )

    def draw(self, found: PathFound, folder: Path) -> tuple[Path, ...]:
        """Draw figure 8."""
        from studies.drawing.mobile_arm import platform_paths

        drives = [(each.name, each.trace) for each in found.drives[:3]]
        return (platform_paths(drives, folder / "platform-path.png"),)


def drive(name: str, agents: dict[str, Agent], period: float, duration: float) -> Drive:
    """Run the paper's task, and measure the run."""
    robot = plant(period=period)
    whole = run(robot, agents, task().piece, duration)
    error = whole.error
    every = round(PERIOD / period)
    trace = Trace(*(column[::every] for column in whole))
    off = heading_to_arm(Kinematics(ARPH), trace.q, trace.base)
    elbow = np.abs(trace.q[:, 2])
    settled = whole.t >= SETTLED
    return Drive(
        name,
        trace,
        (float(error[settled].max()), float(error[~settled].max())),
        float(path_length(trace.base)),
        float(reversal(whole.base_velocity, period)),
        int(cusps(trace.base_velocity)),
        float(turned_about(trace.base)),
        float(path_roughness(trace.base, PERIOD)),
        (float(off.mean()), float(off[-1])),
        (float(elbow.min()), float(elbow[-1])),
    )


def _better(ours: Drive, theirs: Drive) -> str:
    """Return in what a controller is better than MSMA, as text."""
    measures = {
        "error after 2 s": (theirs.error[0], ours.error[0]),
        "distance in reverse": (theirs.reversal, ours.reversal),
        "roughness of the platform's path": (theirs.roughness, ours.roughness),
        "total turn": (theirs.turn, ours.turn),
        "least angle of the elbow": (-theirs.elbow[0], -ours.elbow[0]),
    }
    better = [name for name, (its, of_ours) in measures.items() if its < of_ours]
    return f"Better than MSMA, {theirs.name}: {', '.join(better) or 'in nothing measured here'}."


def _rows(coarse: Drive, mim: Drive, best: Drive, fine: Drive) -> tuple[Row, ...]:
    rows = [
        Row("error after 2 s, MSMA, 60 ms", "at most 3 mm", _mm(coarse.error[0]),
            coarse.error[0] <= 0.003),
        Row("error after 2 s, MSMA, 1 ms", "at most 0.3 mm", _mm(fine.error[0]),
            fine.error[0] <= 0.0003),
        Row("error after 2 s, MIM, 60 ms", "at most 3 mm", _mm(mim.error[0]),
            mim.error[0] <= 0.003),
        Row("distance in reverse, MSMA, 60 ms and 1 ms", "",
            f"{coarse.reversal:.3f} m, {fine.reversal:.3f} m"),
        Row("distance in reverse, MIM", "some, as in the paper", f"{mim.reversal:.2f} m",
            mim.reversal > 0.0),
        Row("cusps, MSMA, 60 ms and 1 ms", "", f"{coarse.cusps}, {fine.cusps}"),
        Row("cusps, MIM", "at least 1, as in the paper", str(mim.cusps), mim.cusps >= 1),
        Row("forward speed at the end, MIM", "negative",
            f"{mim.trace.base_velocity[-1, 0]:+.3f} m/s",
            bool(mim.trace.base_velocity[-1, 0] < 0.0)),
        Row("least elbow from straight, MSMA", "at least 15 deg", _degrees(coarse.elbow[0]),
            bool(np.degrees(coarse.elbow[0]) >= 15.0)),
        Row("error after 2 s, tuned MIM, 60 ms", "", _mm(best.error[0])),
        Row("distance in reverse, and cusps, tuned MIM", "",
            f"{best.reversal:.2f} m, {best.cusps}"),
    ]  # fmt: skip
    for each in (coarse, mim, best):
        name = each.name.split(",")[0]
        rows += [
            Row(f"error of the first 2 s, {name}", "", _mm(each.error[1])),
            Row(f"heading to arm, mean and final, {name}", "",
                f"{_degrees(each.lined_up[0])}, {_degrees(each.lined_up[1])}"),
            Row(f"elbow, least and final, {name}", "",
                f"{_degrees(each.elbow[0])}, {_degrees(each.elbow[1])}"),
            Row(f"platform's path, {name}", "",
                f"{each.length:.2f} m, turned through {_degrees(each.turn)}"),
            Row(f"roughness of the platform's path, {name}", "", f"{each.roughness:.3f} m/s3 rms"),
        ]  # fmt: skip
    return tuple(rows)


def _claims(coarse: Drive, mim: Drive) -> tuple[Claim, ...]:
    heading = np.degrees(coarse.trace.base[-1, 2])
    return (
        Claim(
            "MSMA always goes forward; it first turns slowly to the right, then goes straight "
            "until the end and aligns itself with the arm (4.2.2)",
            f"{coarse.reversal:.2f} m in reverse, {coarse.cusps} cusps; it ends at a heading of "
            f"{heading:.0f} deg, {_degrees(coarse.lined_up[1])} off the arm",
        ),
        Claim(
            "MIM shows a cusp and ends the task moving backwards (4.2.2)",
            f"{mim.cusps} cusps, {mim.reversal:.2f} m in reverse, at the end "
            f"{mim.trace.base_velocity[-1, 0]:+.3f} m/s",
        ),
        Claim(
            "the error stays within 3 mm at 60 ms (4.2.2)",
            f"at most {_mm(coarse.error[0])} after 2 s, MIM {_mm(mim.error[0])}",
        ),
        Claim(
            "with both, the arm is never stretched, the elbow settles near 70 deg (4.2.2)",
            f"MSMA ends at {_degrees(coarse.elbow[1])} and was never under "
            f"{_degrees(coarse.elbow[0])}; MIM at {_degrees(mim.elbow[1])}, "
            f"never under {_degrees(mim.elbow[0])}",
        ),
    )


def _mm(metres: float) -> str:
    return f"{1e3 * metres:.2f} mm"


def _degrees(angle: float | Array) -> str:
    return f"{np.degrees(angle):.0f} deg"
