"""What every fault does to a simulated robot."""

import math

import numpy as np
import pytest

from plant.effects import RUNAWAY_INTERVAL
from plant.faults import Fault
from plant.kinematic import KinematicPlant
from plant.plant import Commands, Setup
from plant.robot import Array
from plant.urdf import load
from tests.plant.moving import (
    ARPH,
    BASE,
    COMMANDS,
    PERIOD,
    REST,
    START,
    after,
    arph,
    measured,
    run,
    true,
)

PLANAR5 = load("planar5")


def inject(plant: KinematicPlant, text: str) -> None:
    """Let a fault begin."""
    plant.inject(Fault.parse(text, plant.robot))


def test_a_locked_joint_brakes_within_its_limits_and_stays() -> None:
    plant = arph()
    run(plant, 1.0)
    inject(plant, "joint/1:locked")
    speed = true(plant).qd[0]
    angles = run(plant, 1.0)
    assert angles[5][0] - true(plant).q[0] == 0.0
    assert true(plant).q[0] - START[0] < 0.2 * 1.0 + speed**2 / (2 * 4.0) + 0.02
    assert true(plant).qd[0] == 0.0
    assert true(plant).qd[1] == pytest.approx(0.1)  # the others go on


@pytest.mark.parametrize("angle", [60.0, -30.0, 150.0, -179.0])
@pytest.mark.parametrize("period", [0.06, 0.001])
def test_a_joint_locked_at_an_angle_runs_there_and_jams(angle: float, period: float) -> None:
    plant = arph(f"joint/1:locked={angle}deg", period=period)
    angles = np.array(run(plant, 4.5))[:, 0]
    assert angles[-1] == pytest.approx(math.radians(angle), abs=1e-9)
    assert np.abs(angles).max() <= math.radians(abs(angle)) + 1e-9  # without overshoot
    speeds = np.diff(angles) / period
    assert np.abs(speeds).max() <= ARPH.max_speed[0] + 1e-9
    assert np.abs(np.diff(speeds)).max() <= 4.0 * period + 1e-6


def test_a_joint_that_turns_for_ever_takes_the_shorter_way_to_its_lock() -> None:
    q = START.copy()
    q[0] = math.radians(350)
    plant = arph("joint/1:locked=10deg", q=q)
    run(plant, 3.0)
    assert math.degrees(true(plant).q[0]) == pytest.approx(370)


def test_a_limp_shoulder_lets_the_arm_sink_without_swinging_until_its_weight_is_below() -> None:
    plant = arph("joint/2:limp")
    angles = np.array(run(plant, 20.0, Commands(np.array([0.5, 0.5, 0, 0, 0, 0]))))[:, 1]
    assert (np.diff(angles) < 1e-12).all()
    assert (np.diff(angles) >= -ARPH.max_speed[1] * PERIOD).all()
    arm = plant.arm()
    weight = np.vstack([arm.points[2:], arm.tip]).mean(axis=0) - arm.points[1]
    assert weight[2] < 0.0
    np.testing.assert_allclose(weight[:2], 0.0, atol=1e-4)


def test_a_limp_elbow_comes_to_hang_from_the_upper_arm() -> None:
    plant = arph("joint/3:limp")
    run(plant, 20.0, REST)
    forearm = true(plant).q[1] + true(plant).q[2]
    assert math.degrees(forearm) == pytest.approx(-90.0, abs=0.1)


def test_a_limp_joint_on_a_vertical_axis_stays() -> None:
    plant = arph("joint/1:limp")
    run(plant, 1.0)
    assert true(plant).q[0] == START[0]


def test_every_joint_of_a_horizontal_arm_stays_where_it_goes_limp() -> None:
    q = np.full(5, 0.3)
    plant = KinematicPlant(Setup(PLANAR5, q, period=PERIOD))
    for number in range(1, 6):
        inject(plant, f"joint/{number}:limp")
    run(plant, 1.0, Commands(np.ones(5)))
    np.testing.assert_array_equal(true(plant).q, q)


def test_a_weak_joint_turns_at_its_share_of_the_speed() -> None:
    plant = arph("joint/1:weak=0.25")
    run(plant, 1.0)
    assert true(plant).qd[0] == pytest.approx(0.25 * 0.2)


def test_a_weak_joint_is_not_made_strong_by_asking_for_more() -> None:
    plant = arph("joint/1:weak=0.5")
    run(plant, 1.0, Commands(np.full(6, 100.0)))
    assert true(plant).qd[0] == pytest.approx(0.5 * ARPH.max_speed[0])


def test_a_runaway_joint_moves_at_random_within_its_share_whatever_the_command() -> None:
    plant = arph("joint/1:runaway=0.3")
    speeds = []
    for _ in range(2000):
        speeds.append(after(plant, COMMANDS).qd[0])
    most = 0.3 * ARPH.max_speed[0]
    assert np.abs(speeds).max() <= most + 1e-12
    assert np.std(speeds) == pytest.approx(most / math.sqrt(3), rel=0.2)
    assert np.mean(speeds) == pytest.approx(0.0, abs=0.2 * most)


@pytest.mark.parametrize("period", [0.06, 0.001])
def test_a_runaway_joint_changes_its_speed_about_twice_a_second(period: float) -> None:
    robots = KinematicPlant(Setup(ARPH, np.tile(START, (500, 1)), BASE, period=period))
    inject(robots, "joint/4:runaway")
    run(robots, 0.3, REST)  # until all have got up to speed
    before = true(robots).qd[:, 3]
    run(robots, 0.3, REST)
    still = np.mean(true(robots).qd[:, 3] == before)
    assert still == pytest.approx(math.exp(-0.3 / RUNAWAY_INTERVAL), abs=0.1)


def test_the_same_seed_gives_the_same_faults() -> None:
    def end(seed: int) -> Array:
        plant = arph("joint/1:runaway", "encoder/2:noisy", seed=seed)
        run(plant, 1.0)
        q: Array = measured(plant).q
        return q

    np.testing.assert_array_equal(end(1), end(1))
    assert (end(1) != end(2))[:2].all()


def test_a_stuck_encoder_reads_the_angle_it_stuck_at() -> None:
    plant = arph()
    run(plant, 0.6)
    angle = true(plant).q[0]
    inject(plant, "encoder/1:stuck")
    run(plant, 0.6)
    readings = measured(plant)
    assert readings.q[0] == angle
    assert readings.qd[0] == 0.0
    np.testing.assert_array_equal(readings.q[1:], true(plant).q[1:])


def test_a_lost_encoder_measures_nothing() -> None:
    plant = arph("encoder/2:lost")
    readings = measured(plant)
    assert np.flatnonzero(np.isnan(readings.q)).tolist() == [1]
    assert np.flatnonzero(np.isnan(readings.qd)).tolist() == [1]


def test_a_biased_encoder_reads_an_angle_too_large() -> None:
    plant = arph("encoder/3:biased=-2deg")
    error = np.degrees(measured(plant).q - true(plant).q)
    np.testing.assert_allclose(error, [0, 0, -2, 0, 0, 0], atol=1e-12)


def test_a_noisy_encoder_errs_by_its_standard_deviation() -> None:
    plant = arph("encoder/3:noisy=0.5deg")
    errors = np.degrees([measured(plant).q - true(plant).q for _ in range(3000)])
    np.testing.assert_allclose(errors.std(axis=0), [0, 0, 0.5, 0, 0, 0], atol=0.03)
    np.testing.assert_allclose(errors.mean(axis=0), 0.0, atol=0.05)


def test_a_sensor_fault_does_not_change_the_truth() -> None:
    broken = arph("encoder/1:biased", "encoder/2:lost", "localiser:noisy")
    broken.read()
    whole = arph()
    run(broken, 1.0), run(whole, 1.0)
    np.testing.assert_array_equal(true(broken).q, true(whole).q)
    np.testing.assert_array_equal(true(broken).position, true(whole).position)


def test_a_lost_localiser_measures_nothing() -> None:
    assert measured(arph("localiser:lost")).position is None


def test_a_noisy_localiser_errs_by_its_standard_deviation_along_each_axis() -> None:
    plant = arph("localiser:noisy=1mm")
    errors = []
    for _ in range(3000):
        sighting = measured(plant)
        errors.append(sighting.position - true(plant).position)
    np.testing.assert_allclose(np.std(errors, axis=0), 0.001, rtol=0.06)


def test_a_noisy_localiser_errs_in_orientation_by_a_fifth_of_a_degree_a_millimetre() -> None:
    plant = arph("localiser:noisy=2mm")
    turns = [measured(plant).rotation.reshape(3, 3) for _ in range(3000)]
    errors = np.stack(turns) @ true(plant).rotation.reshape(3, 3).T
    np.testing.assert_allclose(errors @ errors.swapaxes(-1, -2) - np.eye(3), 0.0, atol=1e-12)
    about = errors[:, [2, 0, 1], [1, 2, 0]]  # about x, y and z of the world, as they are small
    np.testing.assert_allclose(np.degrees(about.std(axis=0)), 0.4, rtol=0.06)


@pytest.mark.parametrize("steps", [0, 1, 5])
def test_a_late_localiser_reports_what_it_measured_so_long_ago(steps: int) -> None:
    plant = arph(f"localiser:late={steps * PERIOD}")
    truth, readings = [true(plant).position], []
    for _ in range(20):
        sighting = measured(plant)
        readings.append(sighting.position)
        truth.append(after(plant, COMMANDS).position)
    for k, position in enumerate(readings):
        np.testing.assert_array_equal(position, truth[max(0, k - steps)])


def test_a_locked_platform_brakes_and_stays() -> None:
    plant = arph()
    run(plant, 1.0)
    inject(plant, "platform:locked")
    run(plant, 1.0)
    base = true(plant).base
    run(plant, 1.0)
    np.testing.assert_array_equal(true(plant).base, base)


def test_a_weak_platform_moves_at_its_share_of_the_speeds() -> None:
    plant = arph("platform:weak=0.5")
    run(plant, 1.0)
    np.testing.assert_allclose(true(plant).base_velocity, [0.05, -0.1])


def test_a_later_fault_of_the_same_part_takes_the_place_of_the_first() -> None:
    plant = arph("joint/1:locked", "joint/2:locked", "joint/1:weak=0.5")
    assert sorted(map(str, plant.faults)) == ["joint/1:weak=0.5", "joint/2:locked"]


@pytest.mark.parametrize(
    "text",
    ["joint/1:locked", "joint/1:runaway", "encoder/1:lost", "localiser:late", "platform:locked"],
)
def test_what_is_ok_again_is_as_before(text: str) -> None:
    plant = arph(text)
    run(plant, 0.6)
    inject(plant, f"{text.partition(':')[0]}:ok")
    assert plant.faults == ()
    run(plant, 0.6)
    np.testing.assert_allclose(true(plant).qd, COMMANDS.joints)
    np.testing.assert_allclose(true(plant).base_velocity, COMMANDS.base)
    np.testing.assert_array_equal(measured(plant).q, true(plant).q)
    sighting = measured(plant)
    np.testing.assert_array_equal(sighting.position, true(plant).position)


EVERY_FAULT = [
    "joint/1:locked",
    "joint/1:locked=60deg",
    "joint/2:limp",
    "joint/3:weak",
    "encoder/1:stuck",
    "encoder/2:lost",
    "encoder/3:biased",
    "localiser:late=300ms",
    "platform:locked",
    "platform:weak",
]


@pytest.mark.parametrize("text", EVERY_FAULT)
def test_a_fault_does_the_same_to_each_of_a_batch(text: str) -> None:
    rng = np.random.default_rng(4)
    q = START + rng.normal(scale=0.1, size=(2, 3, 6))
    fault = Fault.parse(text, ARPH)
    many = KinematicPlant(Setup(ARPH, q, BASE, period=PERIOD), [fault])
    run(many, 1.2)
    sightings = measured(many)
    for index in np.ndindex(2, 3):
        one = KinematicPlant(Setup(ARPH, q[index], BASE, period=PERIOD), [fault])
        run(one, 1.2)
        np.testing.assert_allclose(true(many).q[index], true(one).q, atol=1e-12)
        np.testing.assert_allclose(true(many).base[index], true(one).base, atol=1e-12)
        np.testing.assert_allclose(measured(many).q[index], measured(one).q, atol=1e-12)
        sighting = measured(one)
        np.testing.assert_allclose(sightings.position[index], sighting.position, atol=1e-12)


def test_random_faults_draw_anew_for_each_of_a_batch() -> None:
    faults = [
        Fault.parse(t, ARPH) for t in ("joint/1:runaway", "encoder/2:noisy", "localiser:noisy")
    ]
    many = KinematicPlant(Setup(ARPH, np.tile(START, (50, 1)), BASE, period=PERIOD), faults)
    run(many, 1.2)
    sighting = measured(many)
    assert len(np.unique(true(many).q[:, 0])) == 50
    assert len(np.unique(measured(many).q[:, 1])) == 50
    assert len(np.unique(sighting.position[:, 0])) == 50


def test_a_lift_without_a_motor_falls_and_a_level_slide_stays() -> None:
    robot = load("telescope")
    start = np.array([0.5, 0.2, 0.0, 0.0, 0.0])
    faults = [Fault.parse(text, robot) for text in ("joint/1:limp", "joint/2:limp")]
    plant = KinematicPlant(Setup(robot, start, period=0.02), faults)
    for _ in range(100):
        plant.step()
    q = plant.truth().q
    assert q[0] < 0.3
    assert q[1] == pytest.approx(0.2, abs=1e-6)


def test_a_sliding_joint_runs_to_where_it_locks() -> None:
    robot = load("telescope")
    lock = Fault.parse("joint/1:locked=0.4 m", robot)
    plant = KinematicPlant(Setup(robot, np.zeros(5), period=0.02), [lock])
    for _ in range(300):
        plant.write(Commands(np.full(5, 0.1), np.zeros(2)))
        plant.step()
    assert plant.truth().q[0] == pytest.approx(0.4, abs=1e-6)
