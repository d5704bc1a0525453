"""A cup fetched from a table and brought to a person: without faults, and with one at random."""

import json
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from agents.markers import aim_at
from agents.number import ONE
from agents.tasks import Step
from plant.kinematics import quaternion
from plant.plant import Truth
from plant.robot import Robot
from plant.solids import Solid
from runtime.campaign.report import as_options
from runtime.campaign.simulation import Simulation
from runtime.config.chaos import ChaosEvent
from runtime.config.deployment import Deployment, load
from runtime.processes.lifetime import OK
from runtime.results.reach import hand_error, smallest_error
from runtime.wire.topics import PLATFORM_AGENT
from studies.cases.fetch_courses import Course, course, one_fault
from studies.launching import ROOT, launched
from studies.lockstep import true_motion
from studies.study import Claim, Findings, Progress, Row, Study, StudyError, check_draw, share

DEPLOYMENT = ROOT / "deploy" / "fetch.yaml"
COURSES = 100
"""Number of courses."""
REAL = 10
"""Number of those that are run through real processes too, with the same faults."""
PATIENCE = 90.0
"""Longest time of a run [s]: enough to take a cup a second time."""
STAYS = 2.0
"""How long the cup must stay at the mouth to be delivered [s]."""
AT_THE_MOUTH = 0.03
"""How far from the goal the cup's middle may be [m], which is held a little above it."""
TILTED = np.radians(15.0)
"""Bar on the cup's tilt on the way [rad]."""
TOUCHED = 20.0
"""Bar on all contact forces but the fingers' [N]."""
DELIVERED = 0.95
"""Bar on the share that is delivered with a fault."""
_FILM = (("kill", "goal", 9.0), ("kill", "gripper", 31.0), ("kill", "joint/4", 34.0))


@dataclass(frozen=True)
class Fetched:
    """How a run went.

    Attributes:
        delivered: When the cup had come to the mouth to stay [s]; None if it did not.
        taken: When the gripper first held something [s]; None if it never did.
        lost: When it held it no more [s]; None if it did to the end.
        tilt: Largest angle of the cup against the vertical [rad].
        touched: Largest force of a contact of the robot, but of its fingers [N], and with what.
        chaos: The fault.
        end: What there is to say of a run that missed.
    """

    delivered: float | None
    taken: float | None
    lost: float | None
    tilt: float
    touched: tuple[float, str]
    chaos: tuple[ChaosEvent, ...] = ()
    end: str = ""

    @property
    def is_good(self) -> bool:
        """Whether the cup was delivered, upright and without a hard contact."""
        return self.delivered is not None and self.tilt <= TILTED and self.touched[0] <= TOUCHED


@dataclass(frozen=True)
class Shot:
    """One moment: time [s], truth, opening [m], things by name, and who was killed."""

    t: float
    truth: Truth
    opening: float
    things: dict[str, Solid]
    killed: tuple[str, ...]


@dataclass(frozen=True)
class Found(Findings):
    """Results of the study.

    Attributes:
        robot: The one that fetched.
        shots: Of the film.
        fetched: The runs without and with a fault, in the order of the courses.
    """

    robot: Robot
    shots: tuple[Shot, ...]
    fetched: tuple[tuple[Fetched, ...], tuple[Fetched, ...]]


class Fetch(Study[Found]):
    """Courses in lockstep, with the plant that deploy/fetch.yaml has here, and a few for real."""

    name = "fetch"
    title = "A cup is fetched while agents die"

    def __init__(self, seed: int = 100) -> None:
        """Draw courses and faults from a seed; 0 to 9 are for tuning.

        Raises:
            StudyError: The seed is negative, or there is no checkout.
        """
        check_draw(seed)
        if not DEPLOYMENT.is_file():
            raise StudyError(f"{DEPLOYMENT} does not exist: run this study from a checkout")
        self._seed = seed

    def measure(self, size: float, progress: Progress) -> Found:
        """Fetch on a share `size` of all courses."""
        count, real = max(round(COURSES * size), 1), round(REAL * size)
        progress.begin(2 * count + 5 * real + 1)
        progress.step("film")
        film = replace(load(DEPLOYMENT), chaos=_kills())
        shots: list[Shot] = []
        fetch(film, shots)
        sound, broken, rows = [], [], []
        for number in range(count):
            progress.step(f"course {number}", 2)
            drawn = course(self._seed, number)
            deployment = replace(load(DEPLOYMENT, drawn.overrides()), duration=PATIENCE)
            sound.append(found := fetch(deployment))
            rows += _missed(progress, number, found)
            times = found.taken or 0.0, found.delivered or PATIENCE
            chaos = one_fault(self._seed, number, deployment.roles[1:], *times)
            broken.append(found := fetch(replace(deployment, chaos=chaos)))
            rows += _missed(progress, number, found)
        live = []
        for number in range(real):
            progress.step(f"course {number}, real processes", 5)
            chaos = broken[number].chaos
            live.append(said := _live(course(self._seed, number), chaos, number))
            if said:
                what = f"course {number}, {as_options(chaos)}, real processes"
                rows.append(progress.row(Row(what, "", said)))
        plant = f"plant: {film.plant.class_}; seed {self._seed}"
        return Found(
            rows=(*_rows(sound, broken, live), *rows),
            claims=CLAIMS,
            notes=(plant, *NOTES),
            robot=film.description.robot,
            shots=tuple(shots),
            fetched=(tuple(sound), tuple(broken)),
        )

    def draw(self, found: Found, folder: Path) -> tuple[Path, ...]:
        """Draw moments of the scene of deploy/fetch.yaml, and a film of it."""
        from studies.drawing.fetch import film, moments

        return moments(found, folder / "fetch.png"), film(found, folder / "fetch.gif")


def fetch(deployment: Deployment, shots: list[Shot] | None = None) -> Fetched:
    """Run a deployment in lockstep until the cup is delivered, or its duration is over.

    Args:
        deployment: As deploy/fetch.yaml, perhaps with other places and with chaos.
        shots: Gets what there is to be seen at each period.
    """
    plant = deployment.build_plant()
    run = Simulation(deployment, plant)
    assert deployment.duration is not None
    assert deployment.goal is not None
    gripper = plant.robot.gripper
    assert gripper is not None
    steps: Sequence[Step] = deployment.goal.parameters["steps"]
    mouth = np.array(steps[-1].position)
    cup = next(i for i, each in enumerate(deployment.world) if each.name == "cup")
    over = max((event.ends or event.at for event in deployment.chaos), default=0.0)
    tilt, since, taken, lost = 0.0, None, None, None
    for _ in range(round(deployment.duration / deployment.period)):
        run.step()
        readings, things = plant.read(), plant.solids()
        t, grip = readings.t, readings.sensors.get("gripper")
        holds, pose = bool(getattr(grip, "holds", False)), things[cup].pose
        tilt = max(tilt, float(np.arccos(np.clip(pose[2, 2], -1.0, 1.0))))
        taken = t if holds and taken is None else taken
        lost = None if holds or taken is None else lost or t
        away = float(np.linalg.norm(pose[:3, 3] - mouth))
        since = since or t if holds and away <= AT_THE_MOUTH else None
        if shots is not None:
            opening = float(getattr(grip, "opening", gripper.most))
            killed = tuple(event.kill for event in deployment.chaos if event.kill and event.at <= t)
            names = (each.name for each in deployment.world)
            named = dict(zip(names, things, strict=True))
            shots.append(Shot(t, true_motion(plant), opening, named, killed))
        if since is not None and t >= max(since, over) + STAYS:
            break
    plant.close()
    fingers = {link for each in gripper.fingers for link in each.links}
    touched = [
        (each.force or 0.0, f"the {each.part} touched the {each.object} at {each.t:.1f} s")
        for each in plant.contacts()
        if each.part not in fingers
    ]
    found = Fetched(since, taken, lost, tilt, max(touched, default=(0.0, "")), deployment.chaos)
    return found if found.is_good else replace(found, end=_why(found, run, steps))


def _why(found: Fetched, run: Simulation, steps: Sequence[Step]) -> str:
    """Return what a run that missed came to."""
    if found.delivered is not None:
        if found.tilt > TILTED:
            return f"delivered, but tilted by {np.degrees(found.tilt):.0f} deg"
        return f"delivered, but {found.touched[1]} with {found.touched[0]:.0f} N"
    truth = true_motion(run.plant)
    if run.goal is None:
        return "there never was a goal"
    aim = aim_at(ONE, run.goal, truth.t)
    turn = quaternion(np.reshape(truth.rotation, (3, 3))).tolist()
    off = hand_error(tuple(truth.position), turn, aim)
    roles = [f"joint/{index + 1}" for index in range(len(truth.q))]
    stuck = [i for i, role in enumerate(roles) if role in run.faults or not run.is_up(role)]
    roams = run.is_up(PLATFORM_AGENT)
    nearest = smallest_error(
        run.plant.robot, aim, np.array(truth.base), np.array(truth.q), stuck=stuck, roams=roams
    )
    ends = run.goal.at(run.goal.until)
    step = min(range(len(steps)), key=lambda i: float(np.linalg.norm(ends - steps[i].position)))
    how = "never taken" if found.taken is None else "held" if found.lost is None else "lost"
    lost = f" at {found.lost:.1f} s" if found.lost is not None else ""
    return (
        f"the cup is {how}{lost}; step {step + 1}, the hand {1e3 * off.distance:.0f} mm and "
        f"{np.degrees(off.angle):.0f} deg off its goal, of which any controller could make "
        f"{1e3 * nearest.distance:.0f} mm and {np.degrees(nearest.angle):.0f} deg; "
        f"{found.touched[1] or 'nothing touched'}"
    )


def _kills() -> tuple[ChaosEvent, ...]:
    """Return the chaos of the film."""
    return tuple(ChaosEvent(at=at, **{action: role}) for action, role, at in _FILM)  # type: ignore[arg-type]


def _live(drawn: Course, chaos: tuple[ChaosEvent, ...], number: int) -> str:
    """Return what its launcher says of a course through real processes; "" for delivered."""
    options = ["--speed", "2", "--duration", f"{PATIENCE:g}s", *as_options(chaos).split()]
    for each in drawn.overrides():
        options += ["--set", f"{each.path}={each.value}"]
    with launched(DEPLOYMENT, f"fetch-study-{number}", options) as run:
        summary = json.loads((run / "summary.json").read_text(encoding="utf-8"))
        return "" if summary["code"] == OK else str(summary["headline"])


def _missed(progress: Progress, number: int, found: Fetched) -> list[Row]:
    """Return the line of a run that missed."""
    if found.is_good:
        return []
    what = as_options(found.chaos) or "no fault"
    return [progress.row(Row(f"course {number}, {what}", "", found.end))]


def _rows(sound: list[Fetched], broken: list[Fetched], live: list[str]) -> list[Row]:
    rows = []
    for name, runs, bar in (("no fault", sound, 1.0), ("one fault", broken, DELIVERED)):
        done = sum(each.delivered is not None for each in runs)
        tilt = np.degrees(max(each.tilt for each in runs if each.delivered is not None or bar == 1))
        force, what = max(each.touched for each in runs)
        strict = bar == 1.0
        times = [each.delivered for each in runs if each.delivered is not None]
        late = f"; after {np.median(times):.0f} s in the median" if times else ""
        rows += [
            Row(
                f"delivered, {name}",
                f"{100 * bar:g} %",
                share(done, len(runs)) + late,
                done >= bar * len(runs),
            ),
            Row(
                f"largest tilt of the cup, {name}",
                f"{np.degrees(TILTED):g} deg" if strict else "",
                f"{tilt:.1f} deg",
                bool(np.radians(tilt) <= TILTED) if strict else None,
            ),
            Row(
                f"largest contact force but the fingers', {name}",
                f"{TOUCHED:g} N" if strict else "",
                f"{force:.0f} N" + (f": {what}" if what else ""),
                force <= TOUCHED if strict else None,
            ),
        ]
    if live:
        text = share(live.count(""), len(live))
        rows.append(Row("delivered, one fault, real processes", "", text))
    return rows


CLAIMS: tuple[Claim, ...] = ()
NOTES = (
    "The scene and the agents of deploy/fetch.yaml; places of the cup, the other things, the box "
    "and the person are drawn. Agents, goal source and plant in lockstep; what a process that is "
    "gone has commanded last stays in force for the plant's hold time.",
    "One fault: with equal chances a process (goal source, joints, platform, gripper) is killed "
    "for good, hangs, or is killed and started again, or joint 1, 4 or 6 locks while the cup is "
    "held. Goal source, platform and gripper have a standby each, as in the file.",
    "Delivered: held, and within 3 cm of the mouth for 2 s. Without MuJoCo nothing tilts by "
    "itself, and only the platform touches things.",
)
