"""Robots of others: each file loads with the keys that are proposed, or is refused with a reason.

They are not installed by default, being large: `pip install 'msma[robots]'`.
"""

from importlib import metadata
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from plant.kinematics import Kinematics
from plant.proposal import Proposal, deployment, propose
from plant.robot import RobotError
from plant.urdf import read
from runtime.config.deployment import load

PACKAGES = ("example-robot-data", "hello-robot-stretch-urdf")
REFUSED = {
    "double_pendulum.urdf": ":99: joint 'joint1': <limit lower='0' upper='0'> leaves no room",
    "double_pendulum_continuous.urdf": ":99: joint 'joint1': <limit velocity='0'> must be positive",
    "double_pendulum_simple.urdf": ":94: joint 'joint1': <limit lower='0' upper='0'> leaves no",
    "iris.urdf": ":15: joint 'iris__rotor_0_joint': <limit velocity='0.0'> must be positive",
    "iris_simple.urdf": ":2: robot 'iris': no joint leads to a tip",
    "quadrotor_base.urdf": ":6: robot 'hector': no joint leads to a tip",
    "ur3.urdf": ":6: robot: <robot> has no name",
}
"""Those of example-robot-data 6.0.0 that have no arm, and what is said of them."""


def files(package: str) -> list[Path]:
    """The URDF files of a package; none if it is not installed."""
    try:
        found = metadata.files(package) or []
    except metadata.PackageNotFoundError:
        return []
    return sorted(Path(str(file.locate())) for file in found if file.suffix == ".urdf")


FILES = [file for package in PACKAGES for file in files(package)]
if not FILES:
    reason = f"neither {' nor '.join(PACKAGES)} is installed; `pip install 'msma[robots]'`"
    pytest.skip(reason, allow_module_level=True)
READABLE = [file for file in FILES if file.name not in REFUSED]


def each(file: Path) -> str:
    return "/".join(file.parts[-3:])


@pytest.mark.parametrize("file", READABLE, ids=each)
def test_a_proposed_deployment_loads_as_it_is(file: Path, tmp_path: Path) -> None:
    found = propose(read(file))
    (tmp_path / "x.yaml").write_text(deployment(found, str(file)))
    loaded = load(tmp_path / "x.yaml")
    assert len(loaded.agents) == found.robot.n
    assert [joint.name for joint in loaded.description.robot.joints] == list(found.tips[0].joints)


@pytest.mark.parametrize("file", READABLE, ids=each)
def test_the_tip_is_where_pinocchio_says(file: Path) -> None:
    found = propose(read(file))
    robot, kinematics = found.robot, Kinematics(found.robot)
    model = pin.buildModelFromUrdf(str(file))
    data, rng = model.createData(), np.random.default_rng(0)
    frame = model.getFrameId(found.tips[0].links[0], pin.BODY)
    for _ in range(5):
        q = rng.uniform(np.maximum(robot.lower, -3.0), np.minimum(robot.upper, 3.0))
        pin.framesForwardKinematics(model, data, at(model, found, q.tolist()))
        pose, theirs = kinematics.forward(q), data.oMf[frame]
        np.testing.assert_allclose(pose.tip, theirs.translation, atol=1e-9)
        np.testing.assert_allclose(pose.rotation, theirs.rotation, atol=1e-9)


def at(model: pin.Model, found: Proposal, q: list[float]) -> object:
    """Pinocchio's configuration for the joints of the arm and those that are held."""
    held = {joint.name: joint.position for joint in found.robot.held}
    names = [joint.name for joint in found.robot.joints]
    moved = np.zeros(model.nv)
    for name, position in (held | dict(zip(names, q, strict=True))).items():
        if model.existJointName(name):
            moved[model.joints[model.getJointId(name)].idx_v] = position
    return pin.integrate(model, pin.neutral(model), moved)


@pytest.mark.parametrize("file", [file for file in FILES if file.name in REFUSED], ids=each)
def test_what_has_no_arm_is_refused_with_what_is_missing_and_where(file: Path) -> None:
    with pytest.raises(RobotError) as error:
        propose(read(file))
    assert str(error.value).startswith(f"{file}{REFUSED[file.name]}")
