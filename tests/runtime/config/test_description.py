"""The robot in a deployment: its tip, its locks, its base, and an agent for each joint."""

import re
from pathlib import Path

import pytest

from plant import proposal, urdf
from runtime.config.deployment import Deployment, load
from runtime.config.overrides import Override
from runtime.config.tree import ConfigError

DESCRIPTION = "{file: telescope, tip: hand, locked: {lift: 30 cm, wrist_yaw: 10 deg}, base: fixed}"
TEXT = f"""\
robot: x
description: {DESCRIPTION}
period: 20 ms
start: {{joints: [0.2 m, 0 deg, 0.1]}}
agents:
  - {{role: joint/2, class: agents.joint:HoldAgent}}
  - {{role: joint/*, class: agents.joint:HoldAgent, rate: 3 Hz}}
"""


def read(folder: Path, text: str, *overrides: Override) -> Deployment:
    file = folder / "x.yaml"
    file.write_text(text)
    return load(file, overrides)


def test_a_robot_ends_at_its_tip_without_what_is_locked(tmp_path: Path) -> None:
    robot = read(tmp_path, TEXT).description.robot
    assert [joint.name for joint in robot.joints] == ["extension", "wrist_pitch", "wrist_roll"]
    positions = {held.name: held.position for held in robot.held}
    assert positions["lift"] == 0.3
    assert positions["wrist_yaw"] == pytest.approx(0.1745, abs=1e-4)
    assert robot.drive is None


def test_each_joint_that_is_left_has_an_agent_of_its_own(tmp_path: Path) -> None:
    deployment = read(tmp_path, TEXT)
    assert [agent.role for agent in deployment.agents] == ["joint/2", "joint/1", "joint/3"]
    assert [agent.parameters["rate"] for agent in deployment.agents] == [2.0, 3.0, 3.0]


def test_what_all_joints_have_in_common_can_be_overridden(tmp_path: Path) -> None:
    deployment = read(tmp_path, TEXT, Override("--set", "agents.joint/*.rate", "5 Hz"))
    assert [agent.parameters["rate"] for agent in deployment.agents] == [2.0, 5.0, 5.0]


def test_a_deployment_with_all_of_that_is_dumped_and_read_again(tmp_path: Path) -> None:
    deployment = read(tmp_path, TEXT)
    assert read(tmp_path, deployment.dump()) == deployment


def test_a_holonomic_base_has_its_limits(tmp_path: Path) -> None:
    limits = "max_linear: 50 cm/s, max_angular: 90 deg/s"
    rest = "max_linear_acceleration: 1, max_angular_acceleration: 2, max_lateral: 0.3"
    text = TEXT.replace("base: fixed", f"base: {{kind: holonomic, {limits}, {rest}}}")
    drive = read(tmp_path, text).description.robot.drive
    assert drive is not None
    assert drive.max_velocity == pytest.approx((0.5, 1.5708, 0.3), abs=1e-4)


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("30 cm", "30 deg", "2:58: description.locked.lift: 30 deg is an angle; a length is"),
        ("0.2 m,", "2 deg,", "4:18: start.joints.0: 2 deg is an angle; a length is wanted"),
        ("0.2 m,", "2 m,", "4:18: start.joints.0: 2 m is outside the limits of extension, 0mm to"),
        ("tip: hand", "tip: x", "there is no link 'x' to be the tip; valid are base_link, "),
        ("lift:", "left:", "there is no joint 'left' to be locked; valid are left_wheel_joint,"),
        ("fixed", "tracks", "'tracks' is not a valid choice; valid are fixed, differential, hol"),
        ("fixed", "holonomic", "base: max_linear, max_angular, max_linear_acceleration, max_ang"),
        ("fixed", "{kind: differential, max_lateral: -1}", "of a differential one must be posi"),
        ("{file", "{package: no-such-one, file", "'no-such-one' is not installed; `pip install"),
        ("{file: telescope", "{package: msgpack, file: x.urdf", "'msgpack' has no file x.urdf"),
        ("joint/2", "joint/*", "x.yaml:7:12: agents.joint/1.role: duplicate agent joint/1, first"),
        ("HoldAgent}", "HoldAgent, angle: 20 cm}", "agents.joint/2.angle: 20 cm is a length; an"),
        ("joint/2", "joint/4", "telescope has no part 'joint/4'"),
        ("joint/2", "platform/*", "telescope has no part 'platform/*'"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path: Path, old: str, new: str, says: str) -> None:
    with pytest.raises(ConfigError, match=re.escape(says)):
        read(tmp_path, TEXT.replace(old, new, 1))


@pytest.mark.parametrize("name", ["arph", "planar5", "seven", "telescope"])
def test_a_deployment_that_is_proposed_loads_as_it_is(tmp_path: Path, name: str) -> None:
    found = proposal.propose(urdf.read(name))
    deployment = read(tmp_path, proposal.deployment(found, name))
    assert len(deployment.agents) == found.robot.n + (found.robot.drive is not None)
