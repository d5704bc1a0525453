import numpy as np
import pytest

from agents.scene import Scene
from agents.towing import Towing
from plant.faults import Fault
from studies.lockstep import Event, run
from studies.mobile import ARPH, DURATION, msma, plant, task

TOP = 0.3


def scene(*, carried, missing=(0.0, 0.0), speed=0.07):
    """A platform at the origin that faces and drives along x, as the goal goes."""
    return Scene(
        hand=(carried, 0.0, 1.0),
        drift=(speed, 0.0, 0.0),
        missing=(*missing, 0.0),
        going=(speed, 0.0, 0.0),
        heading=0.0,
        ahead=(1.0, 0.0),
        linear=speed,
        angular=0.0,
        carried=carried,
        aside=0.0,
        off=float(np.hypot(*missing)),
        speed=speed,
    )


@pytest.mark.parametrize(
    ("carried", "speed", "share"), [(0.4, 0.07, 0.0), (-0.5, 0.07, 1.0), (-0.5, 0.0, 0.0)]
)
def test_only_a_hand_behind_the_axle_is_towed_and_only_after_a_goal_that_goes_on(
    carried, speed, share
):
    assert Towing.share(scene(carried=carried, speed=speed)) == pytest.approx(share)


def test_all_goes_on_as_it_is_when_the_hand_is_towed_along_the_path():
    linear, angular = Towing(TOP).speeds(0.06, scene(carried=-0.5))
    assert linear == pytest.approx(0.07)
    assert angular == pytest.approx(0.0)


def test_the_platform_drives_past_a_goal_that_is_ahead_of_the_hand():
    linear, _ = Towing(TOP).speeds(0.06, scene(carried=-0.5, missing=(0.3, 0.0)))
    assert 0.07 < linear <= TOP


def test_it_turns_to_the_side_on_which_the_hand_is_missing_as_one_who_tows():
    _, left = Towing(TOP).speeds(0.06, scene(carried=-0.5, missing=(0.0, 0.1)))
    _, right = Towing(TOP).speeds(0.06, scene(carried=-0.5, missing=(0.0, -0.1)))
    assert left > 0.1
    assert right == pytest.approx(-left)


def test_it_drives_the_more_firmly_the_longer_it_stays_behind_its_place():
    towing, behind = Towing(TOP), scene(carried=-0.5, missing=(0.02, 0.0))
    gained = [towing.speeds(0.06, behind)[0] - behind.linear for _ in range(20)]
    assert gained[-1] == pytest.approx(Towing.KEENEST * gained[0])
    assert np.diff(gained).min() >= 0


def test_it_slows_down_when_the_arm_alone_keeps_the_hand_with_the_goal():
    hurries = scene(carried=-0.5)._replace(linear=0.2)
    linear, _ = Towing(TOP).speeds(0.06, hurries)
    assert 0.07 < linear < 0.2


@pytest.mark.parametrize(("angle", "at"), [(-170, 8.0), (160, 8.0), (-160, 12.0), (155, 12.0)])
def test_a_hand_that_jams_behind_the_axle_in_mid_path_comes_back_to_it(angle, at):
    jam = Event(at, Fault.parse(f"joint/1:locked={angle}deg", ARPH))
    trace = run(plant(), msma(), task().piece, DURATION, events=[jam])
    assert trace.error[-1] < 0.003
    assert (trace.base_velocity[:, 0] >= 0).all()
