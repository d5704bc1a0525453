"""Arms without a model: the agents know nothing of the arm and see only the localiser."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from agents.agent import Array
from plant.faults import Fault
from plant.kinematics import Kinematics, quaternion
from plant.robot import Robot
from plant.urdf import load
from studies.arm_batch import SYNCHRONOUS, Coupling, ReachResult, reach
from studies.fault_cells import MID, TOLERANCE, by_localiser, single_locks
from studies.mobile import DURATION
from studies.mobile_reach import Bools
from studies.study import Claim, Findings, Progress, Row, Study, share

STEPS = 2000
"""Most steps of 0.1 s."""
TICKS = 5
"""Plant steps of 20 ms in a period of the agents, in cases with delay or asynchronous agents."""
ASSUMED = "planar5"
"""The model that the agents are given, of which they use only the top speed and the length,
which is made that of the arm."""
TURNED = np.radians(2.0)
"""Angle to the goal's orientation that counts as reached [rad]."""
JAMMED = slice(0, 36, 3)
"""Which of the single locks of `fault_cells` are run: joint 1 at each 30 deg."""


@dataclass(frozen=True)
class Case:
    """One unknown arm, with the quality of its localiser and its messages.

    Attributes:
        name: Name of the case.
        robot: The true arm.
        noise: Standard deviation of the localiser's error along each axis [m].
        late: Delay of the localiser [s].
        coupling: How agents and plant exchange messages.
        limit: Distance to the goal that counts as reached [m].
        bar: Required share of reached goals; None for no requirement.
        pose: Whether goals have an orientation, of which the localiser's noise is 0.2 deg a mm.
    """

    name: str
    robot: Robot
    noise: float = 0.0
    late: float = 0.0
    coupling: Coupling = SYNCHRONOUS
    limit: float = 0.003
    bar: float | None = None
    pose: bool = False

    def reached(self, found: ReachResult) -> Bools:
        """Tell which hands reached their goals."""
        near: Bools = (found.settled < self.limit) & (found.turned < TURNED)
        return near


@dataclass(frozen=True)
class Found(Findings):
    """Results of the study: every case and its results."""

    cases: tuple[tuple[Case, ReachResult], ...]


class NoModel(Study[Found]):
    """Perception `localiser`, for any arm."""

    name = "no-model"
    title = "Any arm without a model and without encoders, seen by a localiser"

    def measure(self, size: float, progress: Progress) -> Found:
        """Run arms that differ from the model of the agents, with noise, delay and loss."""
        cases = all_cases()
        progress.begin(sum(case.robot.n for case in cases) + 10)
        done = []
        for number, case in enumerate(cases):
            progress.step(case.name, case.robot.n)
            done.append((case, one(case, max(round(200 * size), 8), number)))
        progress.step("mobile arm, joint 1 jammed", 10)
        return Found(
            rows=(*(_row(case, reached) for case, reached in done), *_jammed()),
            claims=_claims(done),
            notes=NOTES,
            cases=tuple(done),
        )

    def draw(self, found: Found, folder: Path) -> tuple[Path, ...]:
        """Draw the distances over time and at the end, in every case."""
        from studies.drawing.planar_studies import Curve, no_model

        noisy, others = (
            [Curve(case.name, reached.history, reached.settled)
             for case, reached in found.cases if (case.bar == 1.0) is noisy_arm]
            for noisy_arm in (True, False)
        )  # fmt: skip
        return (no_model(noisy, others, folder / "no-model.png"),)


def all_cases() -> tuple[Case, ...]:
    """Return every case: arms, noise, delay, loss, synchronous and asynchronous agents."""
    five = load("planar5")
    noisy = [Case(f"{n} joints, 1 mm noise", planar(n), noise=0.001, bar=1.0) for n in range(3, 13)]
    late, manus = Coupling(ticks=TICKS, loss=0.1), replace(load("arph"), drive=None)
    return (
        Case("5 joints", five, limit=0.001),
        *noisy,
        Case("5 joints, 5 mm noise", five, noise=0.005, limit=0.015),
        Case("links of 5 to 35 cm, mounted at 40 deg, 1 mm noise", uneven(), noise=0.001),
        Case("5 joints, 20 ms late, 10 % lost", five, 0.0, 0.02, late, 0.005),
        Case("5 joints, 100 ms late, 10 % lost", five, 0.0, 0.1, late, 0.005, 0.99),
        Case("5 joints, asynchronous agents", five, limit=0.001,
             coupling=Coupling(TICKS, asynchronous=True)),
        Case("5 joints, 1 mm noise, asynchronous agents", five, 0.001,
             coupling=Coupling(TICKS, asynchronous=True)),
        Case("Manus, 3D, 6 joints, 1 mm noise", manus, noise=0.001),
        Case("3D, 7 joints, 1 mm noise", seven(), noise=0.001),
        Case("UR5, pose, 1 mm and 0.2 deg noise", ur5(), 0.001, limit=0.005, bar=0.8, pose=True),
        Case("Manus, pose, 1 mm and 0.2 deg noise", manus, 0.001, limit=0.005, pose=True),
        Case("7 joints, pose, 1 mm and 0.2 deg noise", seven(), 0.001, limit=0.005, pose=True),
        Case("3D, 7 joints, a tenth as long, 0.1 mm noise", resized(seven(), 0.1), 0.0001,
             limit=0.0003),
    )  # fmt: skip


def planar(n: int) -> Robot:
    """Return a planar arm of `n` equal links, 1 m long in total."""
    return planar_of(np.full(n, 1.0 / n))


def uneven() -> Robot:
    """Return planar5 with links of unequal lengths, mounted at another place and angle."""
    changed = planar_of(np.array([0.3, 0.05, 0.35, 0.1, 0.2]))
    mount = np.eye(4)
    turn = np.radians(40.0)
    mount[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    mount[:2, 3] = 0.15, -0.1
    first = replace(changed.joints[0], origin=mount)
    return replace(changed, joints=(first, *changed.joints[1:]))


def planar_of(lengths: Array) -> Robot:
    """Return a planar arm with links of `lengths` (n,) [m], and otherwise as planar5."""
    five = load("planar5")
    joint = five.joints[0]
    shifts = [_along(length) for length in lengths]
    joints = tuple(
        replace(joint, name=f"joint_{i + 1}", origin=np.eye(4) if i == 0 else shifts[i - 1])
        for i in range(len(lengths))
    )
    return replace(five, name=f"planar{len(lengths)}", joints=joints, tip=shifts[-1], visuals=())


def seven() -> Robot:
    """Return a spatial arm of seven joints, 1.1 m long, our `seven`."""
    return load("seven")


def resized(robot: Robot, size: float) -> Robot:
    """Return an arm whose lengths are those of another one times `size`."""

    def sized(frame: Array) -> Array:
        return np.vstack([np.column_stack([frame[:3, :3], size * frame[:3, 3]]), frame[3]])

    joints = tuple(replace(joint, origin=sized(joint.origin)) for joint in robot.joints)
    return replace(robot, joints=joints, tip=sized(robot.tip), visuals=())


def ur5() -> Robot:
    """Return an arm with the lengths of Universal Robots' UR5.

    Its Denavit-Hartenberg parameters d, a [m] and alpha, as published by the manufacturer; joints
    range two turns and move at 180 deg/s at most.
    """
    quarter = 0.5 * np.pi
    links = ((0.089159, 0.0, quarter), (0.0, -0.425, 0.0), (0.0, -0.39225, 0.0),
             (0.10915, 0.0, quarter), (0.09465, 0.0, -quarter), (0.0823, 0.0, 0.0))  # fmt: skip
    frames = [_link(*link) for link in links]
    first = replace(load("seven").joints[0], axis=np.array([0.0, 0.0, 1.0]), kind="revolute",
                    lower=-2.0 * np.pi, upper=2.0 * np.pi, max_speed=np.pi)  # fmt: skip
    joints = tuple(
        replace(first, name=f"joint_{i + 1}", origin=origin)
        for i, origin in enumerate([np.eye(4), *frames[:-1]])
    )
    return replace(load("seven"), name="ur5", joints=joints, tip=frames[-1], visuals=())


def _link(d: float, a: float, alpha: float) -> Array:
    """Return a link's far end (4, 4) as seen from its joint at angle 0."""
    frame = _along(a)
    frame[2, 3] = d
    frame[1:3, 1:3] = [[np.cos(alpha), -np.sin(alpha)], [np.sin(alpha), np.cos(alpha)]]
    return frame


def _along(length: float) -> Array:
    shift = np.eye(4)
    shift[0, 3] = length
    return shift


def one(case: Case, count: int, seed: int) -> ReachResult:
    """Move `count` arms from random postures to goals that other random postures reach.

    Starts and goals are at least a tenth of each joint's range away from its limits.
    """
    robot = case.robot
    rng = np.random.default_rng([5, seed])
    low = np.maximum(robot.lower, -np.pi)
    span = np.minimum(robot.upper, np.pi) - low
    start, aim = (low + span * rng.uniform(0.1, 0.9, (count, robot.n)) for _ in range(2))
    faults: list[Fault] = []
    if case.noise:
        faults.append(Fault("localiser", "noisy", case.noise))
    if case.late:
        faults.append(Fault("localiser", "late", case.late))
    there = Kinematics(robot).forward(aim)
    return reach(
        robot, start, there.tip, steps=STEPS, seed=seed, faults=tuple(faults),
        coupling=case.coupling, enough=0.0 if case.pose else 0.00025, assumed=assumed_model(robot),
        orientations=quaternion(there.rotation) if case.pose else None, perception="localiser",
    )  # fmt: skip


def assumed_model(robot: Robot) -> Robot:
    """Return the model that the agents are given: as many joints, as long, all else invented."""
    five = load(ASSUMED)
    places = [*(joint.origin for joint in robot.joints[1:]), robot.tip]
    length = float(sum(np.linalg.norm(place[:3, 3]) for place in places))
    return replace(five, joints=tuple(five.joints[0] for _ in range(robot.n)), tip=_along(length))


def _jammed() -> tuple[Row, ...]:
    trace = by_localiser(single_locks(MID).part(JAMMED))
    error = trace.error[trace.t > DURATION - 1.0].max(axis=0)
    near = int((error <= TOLERANCE).sum())
    what = f"mobile arm, joint 1 jams at each 30 deg at {MID:g} s, encoders lost"
    measured = f"{near} of {error.size} within 3 mm; worst {1000 * error.max():.1f} mm"
    return (Row(what, "10 of 12 end within 3 mm", measured, near >= 10),)


def _row(case: Case, reached: ReachResult) -> Row:
    ok = case.reached(reached)
    limit = f"{1000 * case.limit:g} mm" + (" and 2 deg" if case.pose else "")
    bar = "" if case.bar is None else f"{100 * case.bar:g} % within {limit}"
    median = np.median(reached.steps)
    near = "no" if np.isinf(median) else f"{median:.0f}"
    turned = f" and {np.degrees(reached.turned.max()):.1f} deg" if case.pose else ""
    return Row(
        case.name, bar,
        f"{share(ok.sum(), ok.size)} within {limit}; {near} steps to 5 mm; "
        f"worst {1000 * reached.settled.max():.1f} mm{turned}",
        None if case.bar is None else bool(ok.mean() >= case.bar),
    )  # fmt: skip


def _claims(done: Sequence[tuple[Case, ReachResult]]) -> tuple[Claim, ...]:
    ok = [case.reached(reached).mean() for case, reached in done]
    worst = int(np.argmin(ok))
    return (
        Claim('"the algorithm can be implemented directly on any manipulator without knowing any '
              'arm measurement" (3.1)',
              f"{len(done)} cases without any measurement of the arm but its length: "
              f"from {100 * ok[worst]:.1f} % ({done[worst][0].name}) "
              f"to {100 * max(ok):g} % of the goals"),
        Claim('"we must accept that a joint may rotate in the wrong direction at some steps" (3.1)',
              f"median steps to 5 mm: {np.median(done[0][1].steps):.0f} without a model"),
    )  # fmt: skip


NOTES = (
    "The agents are given the model of another robot and use only its top speed, and its length, "
    "which is that of the arm. Distances are true ones: the worst in the last second of 200 s, or "
    "earlier if all hands have arrived.",
    "A goal is the hand's position, or pose, in another random posture of the same arm. Late cases "
    "run the plant at 20 ms and the agents at 100 ms; 10 % of the percepts and 10 % of the "
    "commands are lost.",
    "On the mobile arm, no joint that moves has an encoder, and only the platform's agent knows "
    "where the platform is.",
)
