"""A platform among things: how far it is from them, where it stops, what is counted, what falls."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from plant import urdf
from plant.footprint import Footprint
from plant.kinematic import KinematicPlant
from plant.plant import Commands, Setup
from plant.robot import RobotError
from plant.solids import Solid
from plant.world import ObjectPath, WorldObject

ARPH = urdf.load("arph")
PERIOD = 0.06
lengths = st.floats(0.05, 1.0)
solids = st.one_of(
    st.tuples(st.just("box"), st.tuples(lengths, lengths, lengths)),
    st.tuples(st.just("cylinder"), st.tuples(lengths, lengths)),
    st.tuples(st.just("sphere"), st.tuples(lengths)),
)
angles = st.floats(-math.pi, math.pi)


def thing(
    name: str = "table", position: tuple[float, ...] = (2.0, 0.0, 0.35), **more: Any
) -> WorldObject:
    shape = {} if {"cylinder", "sphere"} & more.keys() else {"box": (0.6, 0.6, 0.7)}
    move = {} if {"mass", "path"} & more.keys() else {"fixed": True}
    place = {} if "path" in more else {"position": position}
    return WorldObject(**{"name": name, **shape, **move, **place, **more})


def plant_in(*world: WorldObject, period: float = PERIOD) -> KinematicPlant:
    return KinematicPlant(Setup(ARPH, np.zeros(6), period=period, world=world))


def drive(plant: Any, seconds: Any, forward: Any, turning: Any = 0.0) -> Any:
    """Drive at a speed, and return x, y, heading after each step, and all contacts."""
    path, contacts = [], []
    for _ in range(round(seconds / plant.period)):
        plant.write(Commands((0.0,) * 6, (forward, turning)))
        plant.step()
        path.append(plant.truth().base)
        contacts += plant.contacts()
    return np.array(path), contacts


def points_of(kind: Any, size: Any, rng: Any) -> Any:
    """Draw points of a solid, its surface more often than its inside."""
    if kind == "box":
        unit = rng.uniform(-1, 1, (3000, 3))
        near = np.abs(unit).argmax(axis=1)
        unit[np.arange(2000), near[:2000]] = np.sign(unit[np.arange(2000), near[:2000]])
        return 0.5 * unit * size
    if kind == "sphere":
        unit = rng.normal(size=(3000, 3))
        unit /= np.linalg.norm(unit, axis=1)[:, None]
        unit[2000:] *= rng.uniform(0, 1, (1000, 1))
        return unit * size[0]
    angle, z = rng.uniform(0, 2 * np.pi, 3000), rng.uniform(-0.5, 0.5, 3000)
    radius = np.where(np.arange(3000) < 1500, 1.0, np.sqrt(rng.uniform(0, 1, 3000)))
    z[1500:2500] = np.sign(z[1500:2500]) * 0.5
    flat = size[0] * radius * np.stack([np.cos(angle), np.sin(angle)])
    return np.stack([*flat, size[1] * z], axis=1)


@settings(max_examples=40, deadline=None)
@given(solids, angles, st.tuples(angles, angles, angles), st.booleans(), st.integers(0, 2**32 - 1))
def test_the_gap_is_that_between_the_platform_and_many_points_of_a_solid(
    shape: Any, heading: Any, rpy: Any, upright: Any, seed: Any
) -> None:
    kind, size = shape
    rng = np.random.default_rng(seed)
    position = rng.uniform((-1.2, -1.2, 0.0), (1.2, 1.2, 1.0))
    base = (*rng.uniform(-0.3, 0.3, 2).tolist(), heading)
    pose = thing(position=tuple(position), rpy=(0.0, 0.0, rpy[2]) if upright else rpy).pose_at(0.0)
    footprint = Footprint(ARPH)
    found = footprint.gap(base, Solid(kind, size, pose))
    world = points_of(kind, np.array(size), rng) @ pose[:3, :3].T + pose[:3, 3]
    cosine, sine = math.cos(heading), math.sin(heading)
    flat = world[:, :2] - base[:2]
    local = np.column_stack([flat @ (cosine, sine), flat @ (-sine, cosine), world[:, 2]])
    nearest = min(
        np.linalg.norm(
            np.maximum(np.maximum(block.low - local, local - block.high), 0.0), axis=1
        ).min()
        for block in footprint.blocks
    )
    assert found <= nearest + 1e-9  # never more than there is
    if found < -0.15 and (upright or kind != "cylinder"):
        assert nearest == 0.0, "said to overlap by far, and no point does"
    if found > 0.0:
        assert nearest > 0.0


def test_the_footprint_of_the_arph_is_what_its_base_shows() -> None:
    footprint = Footprint(ARPH)
    assert footprint.low == pytest.approx([-0.25, -0.3, 0.0], abs=1e-9)
    assert footprint.high == pytest.approx([0.45, 0.3, 0.82], abs=1e-9)


def test_a_platform_stops_at_what_it_touches_and_can_go_away_again() -> None:
    plant = plant_in(thing())
    path, contacts = drive(plant, 8.0, 0.3)
    assert path[-1, 0] == pytest.approx(1.7 - 0.45, abs=1e-3)
    assert path[-1, 0] <= 1.7 - 0.45
    assert [(one.part, one.object) for one in contacts] == [("platform", "table")]
    assert contacts[0].t == pytest.approx(4.6, abs=0.4)
    path, contacts = drive(plant, 2.0, -0.3)
    assert path[-1, 0] < 1.0
    assert not contacts
    _, contacts = drive(plant, 4.0, 0.3)
    assert len(contacts) == 1


def test_with_nothing_in_its_way_it_moves_bit_for_bit_as_without_a_world() -> None:
    one, other = plant_in(), plant_in(thing(position=(0.0, 3.0, 0.35)))
    assert np.array_equal(drive(one, 3.0, 0.2, 0.3)[0], drive(other, 3.0, 0.2, 0.3)[0])


def test_it_passes_below_what_is_higher_than_it() -> None:
    path, contacts = drive(plant_in(thing(position=(1.0, 0.0, 2.0))), 8.0, 0.3)
    assert path[-1, 0] > 2.0
    assert not contacts


def test_it_never_goes_through_whatever_it_does() -> None:
    rng = np.random.default_rng(5)
    world = [
        thing("a", (0.9, 0.3, 0.35), yaw=0.4),
        thing("b", (-0.7, -0.5, 0.4), cylinder=(0.2, 0.8)),
        thing("c", (0.2, -0.9, 0.2), sphere=0.2),
    ]
    plant, footprint = plant_in(*world), Footprint(ARPH)
    for _ in range(40):
        path, _ = drive(plant, 0.6, rng.uniform(-0.3, 0.3), rng.uniform(-0.8, 0.8))
        for each in world:
            solid = Solid(each.kind, each.size, each.pose_at(0.0))
            assert min(footprint.gap(tuple(base), solid) for base in path) > -1e-6


def test_one_who_walks_into_it_is_counted_and_it_can_still_drive_away() -> None:
    way = ObjectPath(points=((2.0, 0.0, 0.85), (0.55, 0.0, 0.85)), speed=1.0)
    person = thing("person", cylinder=(0.25, 1.7), path=way)
    plant = plant_in(person)
    _, contacts = drive(plant, 3.0, 0.0)
    assert [one.object for one in contacts] == ["person"]
    path, _ = drive(plant, 1.0, 0.3)
    assert abs(path[-1, 0]) < 1e-3, "it would press on"
    path, _ = drive(plant, 3.0, -0.3)
    assert path[-1, 0] < -0.5


def test_loose_things_fall_to_what_is_below_and_stay_there() -> None:
    world = [thing(), thing("cup", (2.0, 0.0, 1.0), cylinder=(0.04, 0.1), mass=0.3)]
    world.append(thing("ball", (0.0, 3.0, 2.0), sphere=0.1, mass=1.0))
    plant = plant_in(*world, period=0.01)
    assert plant.scene is not None
    drive(plant, 0.3, 0.0)
    fallen = plant.scene.poses[2][2, 3]
    assert fallen == pytest.approx(2.0 - 0.5 * 9.81 * 0.3**2, abs=1e-6)
    drive(plant, 1.0, 0.0)
    assert plant.scene.poses[1][2, 3] == pytest.approx(0.75, abs=1e-5)
    assert plant.scene.poses[2][2, 3] == pytest.approx(0.1, abs=1e-5)


def test_a_batch_of_robots_takes_no_world() -> None:
    with pytest.raises(RobotError, match="a batch of robots has no world"):
        KinematicPlant(Setup(ARPH, np.zeros((2, 6)), period=PERIOD, world=(thing(),)))
