"""The watchdog of the motors."""

import numpy as np
import pytest

from plant.hold import Hold
from plant.simulator import Simulator
from plant.urdf import load

ARPH = load("arph")
START = np.radians([0.0, 60.0, -115.0, 0.0, 0.0, 0.0])


def test_what_was_never_told_stands_still() -> None:
    commands = Hold(ARPH, 0.2).commands(0.0)
    assert not commands.joints.any()
    assert not commands.base.any()


def test_a_command_is_good_until_it_is_older_than_the_hold_time() -> None:
    hold = Hold(ARPH, 0.2)
    hold.tell_joint(2, 0.5, t=1.0)
    hold.tell_base(0.1, -0.2, t=1.0)
    np.testing.assert_array_equal(hold.commands(1.2).joints, [0, 0, 0.5, 0, 0, 0])
    np.testing.assert_array_equal(hold.commands(1.2).base, [0.1, -0.2])
    assert not hold.commands(1.201).joints.any()
    assert not hold.commands(1.201).base.any()


def test_each_joint_has_a_hold_time_of_its_own() -> None:
    hold = Hold(ARPH, 0.2)
    hold.tell_joint(0, 0.5, t=1.0)
    hold.tell_joint(1, 0.6, t=1.1)
    np.testing.assert_array_equal(hold.commands(1.25).joints, [0, 0.6, 0, 0, 0, 0])


def test_only_the_latest_command_counts() -> None:
    hold = Hold(ARPH, 0.2)
    hold.tell_joint(0, 0.5, t=1.0)
    hold.tell_joint(0, -0.3, t=1.1)
    assert hold.commands(1.1).joints[0] == -0.3


def test_commands_once_given_do_not_change() -> None:
    hold = Hold(ARPH, 0.2)
    hold.tell_joint(0, 0.5, t=1.0)
    hold.tell_base(0.1, 0.0, t=1.0)
    commands = hold.commands(1.0)
    hold.tell_joint(0, 0.7, t=1.0)
    hold.tell_base(0.2, 0.0, t=1.0)
    assert (commands.joints[0], commands.base[0]) == (0.5, 0.1)


def test_a_joint_that_is_told_nothing_more_brakes_to_rest_within_its_limits() -> None:
    hold, simulator = Hold(ARPH, 0.2), Simulator(ARPH, START, period=0.01)
    speeds = []
    for k in range(200):
        if k < 100:
            hold.tell_joint(0, 0.8, simulator.state.t)
            hold.tell_base(0.3, 0.0, simulator.state.t)
        speeds.append(simulator.step(hold.commands(simulator.state.t)).qd[0])
    last_told, acceleration = 99, 4.0
    assert speeds[last_told + 20] == pytest.approx(0.8)
    assert speeds[last_told + 21] < 0.8
    assert np.diff(speeds).min() >= -acceleration * 0.01 - 1e-12
    assert speeds[-1] == 0.0
    assert simulator.state.base_velocity[0] == 0.0
