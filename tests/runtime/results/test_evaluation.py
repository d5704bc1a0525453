"""The evaluation of runs, from logs made for the purpose."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from agents.agent import Array
from agents.attitude import rotation_by
from agents.markers import Aim
from plant.kinematics import Kinematics
from runtime.config.deployment import Deployment, Tolerance, load
from runtime.config.overrides import Override
from runtime.processes.lifetime import FAILED, INTERRUPTED, OK
from runtime.results.evaluation import evaluate
from runtime.results.outcome import RunOutcome
from runtime.results.plots import draw
from runtime.results.reach import smallest_error
from runtime.results.run_log import RunLog, RunLogError, read_run_log
from runtime.results.summary import MISSED, Summary, summarise
from runtime.watching.watcher import View
from tests.runtime.conftest import ROOT

ENDED = {"event": "end", "reason": "the run is over", "code": 0}
NOTHING = View(0.0, None, None, None, None, [])


@pytest.fixture(scope="module")
def deployment() -> Deployment:
    return load(ROOT / "deploy" / "arph.yaml")


def run_log(
    deployment: Deployment,
    off: Array | float,
    speed: float = 0.1,
    until: float = 24.0,
    end: Mapping[str, Any] = ENDED,
    turned: Sequence[float] = (0.0, 0.0, 0.0),
) -> RunLog:
    """Make the log of a hand that is `off` [m] sideways from its goal, at each of the states.

    It is turned from upright by the vector `turned` [rad].
    """
    assert deployment.goal is not None
    t = np.arange(0.0, until + 1e-9, 0.06)
    path = deployment.goal.build()
    hand = np.array([path.piece(each).at(each) for each in t])
    hand[:, 0] += off
    m = len(t)
    q = np.tile(deployment.start.joints, (m, 1))
    base = np.tile(deployment.start.base, (m, 1))
    ages = np.zeros((m, 7))
    turns = np.tile(rotation_by(np.array(turned)), (m, 1))
    return RunLog(t, t + 1e9, hand, q, base, np.tile([speed, 0.0], (m, 1)), ages, turns, [end])


def outcome(
    deployment: Deployment, made: RunLog | None, code: int = 0, seen: View = NOTHING
) -> Summary:
    return summarise(deployment, Path("/nowhere"), RunOutcome(code, "-", seen, ()), made)


def test_a_hand_that_stays_near_its_goal_has_reached_it(deployment: Deployment) -> None:
    made = run_log(deployment, 0.001)
    tracking = evaluate(made, deployment).tracking
    assert tracking is not None
    assert tracking.final == pytest.approx(0.001)
    assert tracking.worst == pytest.approx(0.001)
    assert (tracking.within, tracking.since, tracking.nearest) == (1.0, 0.0, None)
    assert outcome(deployment, made).code == OK


def halted(made: RunLog, *gates: tuple[float, str, str | None, float]) -> RunLog:
    """Return the log with changes of the gate: time, mode, who halted it, and time paused."""
    names = "t", "mode", "halted_by", "paused"
    events = [{"event": "gate", **dict(zip(names, gate, strict=True))} for gate in gates]
    return replace(made, events=[*events, *made.events])


def test_a_run_that_ends_halted_before_its_path_does_is_no_success(deployment: Deployment) -> None:
    made = run_log(deployment, 0.001)
    stopped = int(np.searchsorted(made.t, 9.0))
    made.hand[stopped:] = made.hand[stopped]
    summary = outcome(deployment, halted(made, (9.0, "rest", "a page", 0.0)))
    assert summary.code == MISSED
    assert summary.headline.startswith("halted by a page since 9.00 s, before the path's end; ")
    assert [(event.t, event.text) for event in summary.events] == [(9.0, "halted by a page")]


def test_a_run_that_was_halted_and_went_on_is_judged_by_its_path_as_it_was_paused(
    deployment: Deployment,
) -> None:
    assert deployment.goal is not None
    path, made = deployment.goal.build(), run_log(deployment, 0.0)
    gates = (9.0, "rest", "a page", 0.0), (10.2, "rest", None, 1.2), (12.0, "automatic", None, 3.0)
    on_path = np.where(made.t < 9.0, made.t, np.maximum(made.t - 3.0, 9.0))
    hand = np.array([path.piece(each).at(each) for each in on_path])
    hand[:, 0] += 0.001
    summary = outcome(deployment, halted(replace(made, hand=hand), *gates))
    assert summary.code == OK, summary.headline
    assert summary.evaluation is not None
    assert summary.evaluation.tracking is not None
    assert summary.evaluation.tracking.worst == pytest.approx(0.001)
    assert [event.text for event in summary.events] == [
        "halted by a page",
        "at rest",
        "in automatic mode",
    ]


CLOSED = "{class: agents.paths:Pose, position: [0.3 m, 0 m, 0.8 m], grip: 0 cm}"
OPEN = CLOSED.replace("0 cm", "8 cm")


@pytest.mark.parametrize(
    ("goal", "held", "code", "said"),
    [
        (CLOSED, [True], OK, "goal reached: the hand is "),
        (CLOSED, [True, False, True], OK, "goal reached: the hand is "),
        (OPEN, [True, False], OK, "goal reached: the hand is "),
        (CLOSED, [], OK, "goal reached: the hand is "),
        (
            CLOSED,
            [True, False],
            MISSED,
            "goal missed: the cup is lost since 2.00 s, and at x 1.20 m, y -0.10 m, its middle "
            "0.03 m above the floor; the hand is 1.00 mm off ",
        ),
    ],
)
def test_what_the_gripper_should_hold_at_the_end_and_does_not_is_lost(
    goal: str, held: list[bool], code: int, said: str
) -> None:
    deployment = load(ROOT / "deploy" / "arph.yaml", [Override("a test", "goal", goal)])
    grip = {"event": "gripper", "object": "cup", "opening": 0.06}
    grips = [{**grip, "t": float(t), "holds": holds} for t, holds in enumerate(held, 1)]
    place = {"event": "lost", "t": 24.0, "object": "cup", "position": [1.2, -0.1, 0.03]}
    made = run_log(deployment, 0.001)
    summary = outcome(deployment, replace(made, events=[*grips, place, *made.events]))
    assert (summary.code, summary.headline[: len(said)]) == (code, said)


def test_where_a_person_drove_the_hand_is_not_judged(deployment: Deployment) -> None:
    made = run_log(deployment, 0.001)
    driven = (made.t >= 9.0) & (made.t < 12.0)
    made.hand[driven] += 0.5
    gates = (9.0, "shared", None, 0.0), (12.0, "automatic", None, 0.0)
    tracking = evaluate(halted(made, *gates), deployment).tracking
    assert tracking is not None
    assert tracking.worst == pytest.approx(0.001)


def test_the_first_two_seconds_do_not_count(deployment: Deployment) -> None:
    off = np.full(401, 0.001)
    off[:30] = 0.02
    tracking = evaluate(run_log(deployment, off), deployment).tracking
    assert tracking is not None
    assert tracking.worst == pytest.approx(0.001)
    assert tracking.since == pytest.approx(1.8)


def test_a_hand_that_leaves_at_the_end_has_missed(deployment: Deployment) -> None:
    off = np.full(401, 0.001)
    off[-1] = 0.004
    summary = outcome(deployment, run_log(deployment, off))
    assert summary.code == MISSED
    assert "4.00 mm off" in summary.headline


def test_the_summary_of_a_missed_goal_says_how_far_it_is_out_of_reach(
    deployment: Deployment,
) -> None:
    summary = outcome(deployment, run_log(deployment, 0.5))  # where the platform did not move
    assert summary.code == MISSED
    assert "out of reach" in summary.headline
    assert summary.evaluation is not None
    assert summary.evaluation.tracking is not None
    assert summary.evaluation.tracking.nearest == pytest.approx(1.01, abs=0.01)


@pytest.mark.parametrize(("speed", "backwards"), [(0.0, False), (-1e-3, True), (0.2, False)])
def test_a_platform_that_goes_backwards_is_seen(
    deployment: Deployment, speed: float, backwards: bool
) -> None:
    platform = evaluate(run_log(deployment, 0.0, speed), deployment).platform
    assert platform is not None
    assert platform.reversed == backwards


@pytest.mark.parametrize(
    ("end", "code"),
    [
        ({}, FAILED),
        ({"event": "end", "reason": "IndexError", "code": 1}, FAILED),
        ({"event": "end", "reason": "asked to stop", "code": 0}, INTERRUPTED),
    ],
    ids=["killed", "failed", "stopped"],
)
def test_a_plant_that_ends_early_decides_the_exit_code(
    deployment: Deployment, end: dict[str, Any], code: int
) -> None:
    made = run_log(deployment, 0.0, until=9.0, end={"event": "x", **end})
    assert outcome(deployment, made).code == code


def test_a_log_that_ends_before_its_plant_is_no_success(deployment: Deployment) -> None:
    assert deployment.duration is not None
    made = run_log(deployment, 0.0, until=9.0)
    summary = outcome(deployment, made, seen=NOTHING._replace(t=deployment.duration))
    assert summary.code == FAILED
    assert "is the disk full?" in summary.headline


def test_a_robot_that_never_moved_has_failed(deployment: Deployment, tmp_path: Path) -> None:
    assert outcome(deployment, None).code == FAILED
    assert outcome(deployment, None, INTERRUPTED).code == INTERRUPTED
    with pytest.raises(RunLogError, match="no motion"):
        read_run_log(tmp_path)


def test_only_the_last_plant_counts_and_cut_lines_do_not(tmp_path: Path) -> None:
    tick = '{"event": "tick", "wall": 1, "t": %g, "hand": [0, 0, 0], "q": [0], "base": [0, 0, 0], '
    tick += '"base_velocity": [0, 0], "age": []}'
    start = '{"event": "start", "pid": 1}'
    lines = [start, tick % 1, tick % 2, start, tick % 3, (tick % 4)[:30]]
    (tmp_path / "plant.jsonl").write_text("\n".join(lines))
    assert read_run_log(tmp_path).t.tolist() == [3.0]


def test_a_goal_that_the_arm_reaches_is_found_to_be_within_reach(deployment: Deployment) -> None:
    robot = deployment.description.robot
    rng = np.random.default_rng(1)
    base = np.array([1.0, -2.0, 0.5])
    start = np.array(deployment.start.joints)
    lower, upper = np.maximum(robot.lower, -math.pi), np.minimum(robot.upper, math.pi)
    for q in rng.uniform(lower, upper, (5, robot.n)):
        aim = Aim(tuple(Kinematics(robot).forward(q, base).tip.tolist()), None, False)
        assert smallest_error(robot, aim, base, start).distance < 1e-3


def test_the_distance_of_a_goal_beyond_the_stretched_arm_is_found(deployment: Deployment) -> None:
    robot = deployment.description.robot
    start = np.array(deployment.start.joints)
    x, y, z = Kinematics(robot).forward(start).points[1].tolist()
    found = smallest_error(robot, Aim((x + 5.0, y, z), None, False), np.zeros(3), start)
    assert found == pytest.approx((5.0 - 0.88, 0.0), abs=0.02)


@pytest.fixture(scope="module")
def upright(deployment: Deployment) -> Deployment:
    """The same with a hand that is to be upright."""
    assert deployment.goal is not None
    parameters = {**deployment.goal.parameters, "rpy": (0.0, 0.0, 0.0)}
    return replace(deployment, goal=replace(deployment.goal, parameters=parameters))


DEG = math.pi / 180


@pytest.mark.parametrize(
    ("turned", "off", "free", "code"),
    [
        ((0.9 * DEG, 0.0, 0.0), 0.001, None, OK),
        ((1.1 * DEG, 0.0, 0.0), 0.001, None, MISSED),
        ((0.9 * DEG, 0.0, 0.0), 0.004, None, MISSED),
        ((0.0, 0.0, 90 * DEG), 0.001, "roll", OK),
        ((1.1 * DEG, 0.0, 0.0), 0.001, "roll", MISSED),
        ((90 * DEG, 0.0, 0.0), 0.001, "all", OK),
        ((math.nan, 0.0, 0.0), 0.001, None, FAILED),
    ],
)
def test_position_and_orientation_are_both_judged(
    upright: Deployment, turned: tuple[float, ...], off: float, free: str | None, code: int
) -> None:
    assert upright.goal is not None
    parameters = {**upright.goal.parameters, "free": free}
    freed = replace(upright, goal=replace(upright.goal, parameters=parameters))
    if code == FAILED:  # nobody saw how the hand was turned
        made = run_log(freed, off, turned=turned)
        assert evaluate(made, freed).tracking is None
    else:
        assert outcome(freed, run_log(freed, off, turned=turned)).code == code


def test_the_summary_of_a_pose_has_both_errors_and_both_tolerances(upright: Deployment) -> None:
    good = outcome(upright, run_log(upright, 0.001, turned=(0.0, 0.5 * DEG, 0.0)))
    assert good.headline == (
        "goal reached: the hand is 1.00 mm and 0.50 deg off at 24.00 s, within 3.00 mm and 1.00 deg"
    )
    assert "1.00 mm and 0.50 deg off at worst after 2 s" in good.text()
    assert "within 3.00 mm and 1.00 deg for 100.0 % of that time" in good.text()
    read = json.loads(good.to_json())
    assert read["evaluation"]["tracking"]["final_angle"] == pytest.approx(0.5 * DEG)
    assert (read["tolerance"], read["orientation_tolerance"]) == (0.003, pytest.approx(DEG))
    bad = outcome(upright, run_log(upright, 0.0, turned=(0.0, 2 * DEG, 0.0)))
    assert bad.headline == "goal missed: the hand is 0.00 mm and 2.00 deg off at 24.00 s"
    wide = replace(upright, tolerance=Tolerance(orientation=3 * DEG))
    assert outcome(wide, run_log(wide, 0.0, turned=(0.0, 2 * DEG, 0.0))).code == OK


def test_the_summary_of_a_position_says_nothing_of_angles(deployment: Deployment) -> None:
    made = outcome(deployment, run_log(deployment, 0.001, turned=(1.0, 0.0, 0.0)))
    assert made.headline == "goal reached: the hand is 1.00 mm off at 24.00 s, within 3.00 mm"
    assert "within 3.00 mm for 100.0 % of that time, for good since 0.00 s" in made.text()
    assert "1.00 mm off at worst after 2 s" in made.text()


@pytest.mark.parametrize("turned", [(0.0, 0.0, 0.0), (0.0, 0.5 * DEG, 0.0), (math.nan, 0.0, 0.0)])
def test_a_plot_is_drawn_of_a_pose_too(
    upright: Deployment, tmp_path: Path, turned: tuple[float, ...]
) -> None:
    draw(run_log(upright, 0.001, turned=turned), upright, (), tmp_path / "path.png")
    assert (tmp_path / "path.png").stat().st_size > 10_000
