"""The belt of range sensors: where they look, what they see, and how they fail."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from plant import urdf
from plant.belt import Belt, BeltError, Ranges
from plant.faults import Fault, FaultError
from plant.kinematic import KinematicPlant
from plant.plant import Setup
from plant.ranges import RangeFinder
from plant.world import WorldObject
from tests.plant.test_scene import points_of

WALL = WorldObject(name="wall", box=(0.2, 6.0, 2.0), position=(2.1, 0.0, 1.0), fixed=True)
BALL = WorldObject(name="ball", sphere=0.3, position=(0.6, 1.2, 0.3), fixed=True)


def exact(**more: Any) -> Belt:
    return Belt(**{"sensors": 5, "noise": 0.0, **more})


def plant_with(belt: Belt, *world: WorldObject, period: float = 0.06) -> KinematicPlant:
    robot = replace(urdf.load("arph"), belt=belt)
    return KinematicPlant(Setup(robot, np.zeros(6), period=period, world=world))


def ranges(plant: KinematicPlant) -> tuple[float, ...]:
    reading = plant.read().sensors["ranges"]
    assert isinstance(reading, Ranges)
    return reading.ranges


def test_sensors_look_outward_from_the_left_to_the_right() -> None:
    layout = exact(spread=math.pi, radius=0.2, centre=0.1).layout
    assert [each.bearing for each in layout] == pytest.approx(
        [math.pi / 2, math.pi / 4, 0.0, -math.pi / 4, -math.pi / 2]
    )
    assert (layout[0].x, layout[0].y) == pytest.approx((0.1, 0.2))
    assert (layout[2].x, layout[2].y) == pytest.approx((0.3, 0.0))


def test_a_range_is_that_of_the_nearest_surface_in_the_cone() -> None:
    belt = exact(cone=math.radians(40), rays=400)
    finder = RangeFinder(belt, 0)
    scene = plant_with(belt, WALL, BALL).scene
    assert scene is not None
    base, rng = (0.1, -0.2, 0.3), np.random.default_rng(1)
    found = finder.true_ranges(base, scene.solids())
    cloud = [
        points_of(each.kind, np.array(each.size), rng) + each.position
        for each in (WALL, BALL)
        for _ in range(20)
    ]
    cosine, sine = math.cos(base[2]), math.sin(base[2])
    for sensor, far in zip(belt.layout, found, strict=True):
        x = base[0] + cosine * sensor.x - sine * sensor.y
        y = base[1] + sine * sensor.x + cosine * sensor.y
        away = np.concatenate(cloud) - (x, y, belt.height)
        distance = np.linalg.norm(away, axis=1)
        yaw = base[2] + sensor.bearing
        ahead = away @ (math.cos(yaw), math.sin(yaw), 0.0) / distance
        nearest = distance[ahead >= math.cos(0.5 * belt.cone)].min(initial=math.inf)
        assert far == nearest or far == pytest.approx(nearest, abs=0.05)


def test_where_there_is_no_echo_it_reads_the_largest_range() -> None:
    assert ranges(plant_with(exact(most=3.0))) == (3.0,) * 5
    left, *_, right = ranges(plant_with(exact(most=2.5), WALL, BALL))
    assert left < 2.0
    assert right == 2.5


def test_what_is_nearer_than_the_least_reads_as_the_least() -> None:
    near = replace(WALL, position=(0.56, 0.0, 1.0))
    assert ranges(plant_with(exact(least=0.1), near))[2] == 0.1


def test_a_wall_at_a_flat_angle_is_a_mirror() -> None:
    flat = replace(WALL, box=(8.0, 0.2, 2.0), position=(4.0, -0.6, 1.0))
    seen = exact(sensors=1, cone=math.radians(50), rays=50)
    (with_echo,) = ranges(plant_with(seen, flat))
    (mirrored,) = ranges(plant_with(replace(seen, mirror=math.radians(40)), flat))
    assert with_echo < 1.5
    assert mirrored == seen.most


def test_noise_and_drop_outs_come_as_often_as_they_should() -> None:
    plant = plant_with(exact(sensors=1, noise=0.02, dropouts=0.2), WALL)
    found = np.array([ranges(plant)[0] for _ in range(2000)])
    dropped = found == 3.0
    assert np.mean(dropped) == pytest.approx(0.2, abs=0.05)
    assert np.std(found[~dropped]) == pytest.approx(0.02, rel=0.1)


def test_a_slow_belt_repeats_its_last_measurement() -> None:
    plant = plant_with(exact(sensors=1, noise=0.01, rate=5.0), WALL, period=0.05)
    found = []
    for _ in range(40):
        found.append(ranges(plant)[0])
        plant.step()
    assert len(set(found)) == 10


@pytest.mark.parametrize(
    ("fault", "wanted"),
    [("lost", lambda now: math.isnan(now)), ("stuck", lambda now: now == pytest.approx(1.55))],
)
def test_one_sensor_fails_and_the_others_go_on(fault: str, wanted: Any) -> None:
    plant = plant_with(exact(), WALL)
    before = ranges(plant)
    plant.inject(Fault.parse(f"ranges/3:{fault}", plant.robot))
    ranges(plant)
    assert plant.scene is not None
    plant.scene.poses[0] = replace(WALL, position=(1.6, 0.0, 1.0)).pose_at(0.0)
    after = ranges(plant)
    assert wanted(after[2]), after
    assert (after[0], after[4]) == (before[0], before[4])
    plant.inject(Fault.parse("ranges/3:ok", plant.robot))
    assert ranges(plant)[2] == pytest.approx(1.05)


def test_a_noisy_sensor_errs() -> None:
    plant = plant_with(exact(), WALL)
    plant.inject(Fault.parse("ranges/3:noisy=20cm", plant.robot))
    assert np.std([ranges(plant)[2] for _ in range(300)]) == pytest.approx(0.2, rel=0.2)


def test_a_robot_without_a_belt_has_no_such_fault() -> None:
    with pytest.raises(FaultError, match="has no ranges/3"):
        Fault.parse("ranges/3:lost", urdf.load("arph"))
    with pytest.raises(FaultError, match="valid are ranges/1 to ranges/5"):
        Fault.parse("ranges/6:lost", replace(urdf.load("arph"), belt=exact()))


@pytest.mark.parametrize(
    ("attribute", "value"),
    [
        ("sensors", 0),
        ("spread", 7.0),
        ("cone", -0.1),
        ("rays", 0),
        ("least", 4.0),
        ("noise", -1.0),
        ("dropouts", 1.1),
        ("mirror", 2.0),
        ("rate", 0.0),
    ],
)
def test_a_belt_that_cannot_be_is_refused_by_the_name_of_what_is_wrong(
    attribute: str, value: Any
) -> None:
    with pytest.raises(BeltError, match=f"^{attribute}: "):
        exact(**{attribute: value})
