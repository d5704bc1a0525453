"""No model at all: an arm that nobody told the agents about, seen by a localiser only."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from agents.agent import Array
from plant.faults import Fault
from plant.kinematics import Kinematics
from plant.robot import Robot
from plant.urdf import load
from studies.arm_batch import IN_STEP, Meeting, Reached, reach
from studies.study import Claim, Findings, Row, Study, Watch, share

STEPS = 2000
"""Of 0.1 s, at most."""
TICKS = 5
"""Plant steps in a period of the agents, where the eye is late: 20 ms each."""
BELIEVED = "planar5"
"""What the agents are told that they are part of: of this, they only use the top speed."""


@dataclass(frozen=True)
class Case:
    """One unknown arm and one way to see and meet it.

    Attributes:
        name: For people.
        robot: What it truly is.
        noise: Standard deviation of the localiser's error along each axis [m].
        late: [s]
        meeting: How agents and plant meet.
        limit: Within which the hand is to end [m].
        bar: Share of the goals that must; None if it is only shown.
    """

    name: str
    robot: Robot
    noise: float = 0.0
    late: float = 0.0
    meeting: Meeting = IN_STEP
    limit: float = 0.003
    bar: float | None = None


@dataclass(frozen=True)
class Found(Findings):
    """What the picture needs: every case and how near its hands came."""

    cases: tuple[tuple[Case, Reached], ...]


class NoModel(Study[Found]):
    """Perception `localiser`, whatever the arm."""

    name = "no-model"
    title = "No model, no encoders: any arm, seen from outside"

    def measure(self, size: float, watch: Watch) -> Found:
        """Try arms that were changed without telling the agents, seen badly and late."""
        cases = all_cases()
        watch.expect(sum(case.robot.n for case in cases))
        done = []
        for number, case in enumerate(cases):
            watch.at(case.name, case.robot.n)
            done.append((case, one(case, max(round(200 * size), 8), number)))
        return Found(
            rows=tuple(_row(case, reached) for case, reached in done),
            claims=_claims(done),
            notes=NOTES,
            cases=tuple(done),
        )

    def draw(self, found: Found, folder: Path) -> tuple[Path, ...]:
        """Draw how the distance goes, and where it ends, in every case."""
        from studies.drawing.planar_studies import Curve, no_model

        noisy, others = (
            [Curve(case.name, reached.history, reached.settled)
             for case, reached in found.cases if (case.bar == 1.0) is alike]
            for alike in (True, False)
        )  # fmt: skip
        return (no_model(noisy, others, folder / "no-model.png"),)


def all_cases() -> tuple[Case, ...]:
    """Return every case: arms, noise, delay, loss, in step and out of step."""
    five = load("planar5")
    noisy = [Case(f"{n} joints, 1 mm noise", planar(n), noise=0.001, bar=1.0) for n in range(3, 13)]
    late = Meeting(ticks=TICKS, loss=0.1)
    return (
        Case("5 joints", five, limit=0.001),
        *noisy,
        Case("5 joints, 5 mm noise", five, noise=0.005, limit=0.015),
        Case("links of 5 to 35 cm, mounted at 40 deg, 1 mm noise", uneven(), noise=0.001),
        Case("5 joints, 20 ms late, 10 % lost", five, 0.0, 0.02, late, 0.005),
        Case("5 joints, 100 ms late, 10 % lost", five, 0.0, 0.1, late, 0.005, 0.99),
        Case("5 joints, out of step", five, meeting=Meeting(TICKS, out_of_step=True), limit=0.001),
        Case("5 joints, 1 mm noise, out of step", five, 0.001,
             meeting=Meeting(TICKS, out_of_step=True)),
        Case("Manus, 3D, 6 joints, 1 mm noise", replace(load("arph"), drive=None), noise=0.001),
        Case("3D, 7 joints, 1 mm noise", seven(), noise=0.001),
    )  # fmt: skip


def planar(n: int) -> Robot:
    """Return a planar arm of `n` equal links, 1 m in all."""
    return planar_of(np.full(n, 1.0 / n))


def uneven() -> Robot:
    """Return planar5 with other links, mounted turned and elsewhere."""
    changed = planar_of(np.array([0.3, 0.05, 0.35, 0.1, 0.2]))
    mount = np.eye(4)
    turn = np.radians(40.0)
    mount[:2, :2] = [[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]
    mount[:2, 3] = 0.15, -0.1
    first = replace(changed.joints[0], origin=mount)
    return replace(changed, joints=(first, *changed.joints[1:]))


def planar_of(lengths: Array) -> Robot:
    """Return a planar arm with links of those lengths (n,) [m], else as planar5."""
    like = load("planar5")
    joint = like.joints[0]
    shifts = [_along(length) for length in lengths]
    joints = tuple(
        replace(joint, name=f"joint_{i + 1}", origin=np.eye(4) if i == 0 else shifts[i - 1])
        for i in range(len(lengths))
    )
    return replace(like, name=f"planar{len(lengths)}", joints=joints, tip=shifts[-1], visuals=())


def seven() -> Robot:
    """Return an arm of seven joints, read from the URDF beside this file, 1.1 m long."""
    return load(Path(__file__).with_name("seven.urdf"))


def _along(length: float) -> Array:
    shift = np.eye(4)
    shift[0, 3] = length
    return shift


def one(case: Case, count: int, seed: int) -> Reached:
    """Bring `count` arms from anywhere to places that the arm can reach, as another posture shows.

    Starts and goals are at least a tenth of each joint's range from its stops.
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
    return reach(
        robot, start, Kinematics(robot).forward(aim).tip, steps=STEPS, seed=seed,
        faults=tuple(faults), meeting=case.meeting, enough=0.00025, believed=told(robot),
        perception="localiser",
    )  # fmt: skip


def told(robot: Robot) -> Robot:
    """Return the robot that the agents are told of: as many joints, all else made up."""
    five = load(BELIEVED)
    return replace(five, joints=tuple(five.joints[0] for _ in range(robot.n)))


def _row(case: Case, reached: Reached) -> Row:
    ok = reached.settled < case.limit
    bar = "" if case.bar is None else f"{100 * case.bar:g} % within {1000 * case.limit:g} mm"
    median = np.median(reached.steps)
    near = "no" if np.isinf(median) else f"{median:.0f}"
    return Row(
        case.name, bar,
        f"{share(ok.sum(), ok.size)} within {1000 * case.limit:g} mm; {near} steps to 5 mm; "
        f"worst {1000 * reached.settled.max():.1f} mm",
        None if case.bar is None else bool(ok.mean() >= case.bar),
    )  # fmt: skip


def _claims(done: list[tuple[Case, Reached]]) -> tuple[Claim, ...]:
    ok = [(reached.settled < case.limit).mean() for case, reached in done]
    worst = int(np.argmin(ok))
    return (
        Claim('"the algorithm can be implemented directly on any manipulator without knowing any '
              'arm measurement" (3.1)',
              f"{len(done)} arms and ways to see them, told nothing: from {100 * ok[worst]:.1f} % "
              f"({done[worst][0].name}) to {100 * max(ok):g} % of the goals"),
        Claim('"we must accept that a joint may rotate in the wrong direction at some steps" (3.1)',
              f"median steps to 5 mm: {np.median(done[0][1].steps):.0f} without a model"),
    )  # fmt: skip


NOTES = (
    "The agents believe to be part of another robot; of it they use no more than the top speed. "
    "True distances are judged: the worst in the last second of 200 s, or sooner if all are there.",
    "Goals are where the hand is in another random posture of the same arm. Late cases run the "
    "plant at 20 ms and the agents at 100 ms; 10 % of percepts and 10 % of commands are lost.",
)
