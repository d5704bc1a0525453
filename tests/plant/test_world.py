"""Objects of the world that move by themselves."""

import numpy as np
import pytest

from plant.world import ObjectPath, WorldObject

POINTS = ((0.0, 0.0, 1.0), (3.0, 4.0, 1.0), (3.0, 0.0, 1.0))


def test_a_walker_at_a_speed_is_where_the_length_of_the_way_says() -> None:
    path = ObjectPath(points=POINTS, speed=2.0, start=1.0)
    assert path.position_at(0.5).tolist() == [0, 0, 1]
    assert path.position_at(1.0 + 1.25) == pytest.approx([1.5, 2.0, 1.0])
    assert path.position_at(1.0 + 2.5 + 1.0) == pytest.approx([3.0, 2.0, 1.0])
    assert path.position_at(100.0).tolist() == [3, 0, 1]


def test_its_velocity_is_how_its_position_changes() -> None:
    path = ObjectPath(points=POINTS, times=(1.0, 2.0, 6.0))
    for t in (0.5, 1.5, 4.0, 7.0):
        change = (path.position_at(t + 1e-6) - path.position_at(t - 1e-6)) / 2e-6
        assert path.velocity_at(t) == pytest.approx(change, abs=1e-6)


def test_it_stays_upright_as_it_goes() -> None:
    path = ObjectPath(points=POINTS, speed=1.0)
    walker = WorldObject(name="person", cylinder=(0.3, 1.7), path=path, yaw=0.5)
    pose = walker.pose_at(2.5)
    assert pose[:3, 3] == pytest.approx([1.5, 2.0, 1.0])
    assert pose[:3, :3] == pytest.approx(walker.pose_at(0.0)[:3, :3])
    assert np.linalg.det(pose) == pytest.approx(1.0)
