"""Forward kinematics, against itself, against known postures and against Pinocchio."""

import tempfile
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from plant.kinematics import ArmPose, Kinematics, quaternion
from plant.robot import Array, Robot
from plant.urdf import ROBOTS, load
from tests.plant import urdf_texts

NAMES = ["arph", "planar5", "seven", "telescope"]
ROBOT = {name: load(name) for name in NAMES}
KINEMATICS = {name: Kinematics(ROBOT[name]) for name in NAMES}
angles = st.floats(-7.0, 7.0, allow_subnormal=False)
joint_angles = {name: arrays(float, ROBOT[name].n, elements=angles) for name in NAMES}
bases = arrays(float, 3, elements=angles)
vectors = arrays(float, 3, elements=st.floats(-2.0, 2.0, allow_subnormal=False))


def test_table_1_of_the_paper_is_the_start() -> None:
    q = np.radians([0.0, 60.0, -115.0, 0.0, 0.0, 0.0])
    pose = KINEMATICS["arph"].forward(q, np.array([-0.15, 0.0, 0.0]))
    assert np.linalg.norm(pose.tip - [0.20, -0.18, 0.79]) < 0.001


def test_a_stretched_planar_arm_reaches_one_metre() -> None:
    pose = KINEMATICS["planar5"].forward(np.zeros(5))
    np.testing.assert_allclose(pose.tip, [1.0, 0.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(pose.points[:, 0], [0.0, 0.2, 0.4, 0.6, 0.8])


def test_the_wrist_is_32_cm_from_the_elbow_and_the_grip_16_cm_further() -> None:
    pose = KINEMATICS["arph"].forward(np.radians([10.0, 20.0, 30.0, 40.0, 0.0, 60.0]))
    elbow, wrist = pose.points[2], pose.points[4]
    assert np.linalg.norm(wrist - elbow) == pytest.approx(0.32)
    assert np.linalg.norm(pose.tip - wrist) == pytest.approx(0.16)


@pytest.mark.parametrize("name", NAMES)
@given(data=st.data())
def test_axes_and_points_are_the_columns_of_the_jacobian(name: str, data: st.DataObject) -> None:
    q, base = data.draw(joint_angles[name]), data.draw(bases)
    kinematics, step = KINEMATICS[name], 1e-6
    pose = kinematics.forward(q, base)
    columns = np.cross(pose.axes, pose.tip - pose.points)
    slides = [joint.slides for joint in ROBOT[name].joints]
    columns[slides] = pose.axes[slides]
    shift = step * np.eye(len(q))
    differences = kinematics.forward(q + shift, base).tip - kinematics.forward(q - shift, base).tip
    np.testing.assert_allclose(columns, differences / (2 * step), atol=1e-8)


@pytest.mark.parametrize("name", NAMES)
@given(data=st.data())
def test_the_hand_turns_about_the_axes(name: str, data: st.DataObject) -> None:
    q, i = data.draw(joint_angles[name]), data.draw(st.integers(0, ROBOT[name].n - 1))
    kinematics, step = KINEMATICS[name], 1e-6
    pose = kinematics.forward(q)
    shift = step * np.eye(len(q))[i]
    turned = kinematics.forward(q + shift).rotation - kinematics.forward(q - shift).rotation
    turning = np.cross(pose.axes[i], pose.rotation.T).T
    if ROBOT[name].joints[i].slides:
        turning[:] = 0.0
    np.testing.assert_allclose(turning, turned / (2 * step), atol=1e-8)


@pytest.mark.parametrize("name", NAMES)
@given(data=st.data())
def test_a_base_moves_everything_with_it(name: str, data: st.DataObject) -> None:
    q, base = data.draw(joint_angles[name]), data.draw(bases)
    still, moved = KINEMATICS[name].forward(q), KINEMATICS[name].forward(q, base)
    sine, cosine = np.sin(base[2]), np.cos(base[2])
    turn = np.array([[cosine, -sine, 0], [sine, cosine, 0], [0, 0, 1]])
    shift = np.array([base[0], base[1], 0.0])
    np.testing.assert_allclose(moved.tip, turn @ still.tip + shift, atol=1e-12)
    np.testing.assert_allclose(moved.rotation, turn @ still.rotation, atol=1e-12)
    np.testing.assert_allclose(moved.points, still.points @ turn.T + shift, atol=1e-12)
    np.testing.assert_allclose(moved.axes, still.axes @ turn.T, atol=1e-12)


def made(pose: ArmPose) -> tuple[Array, ...]:
    return pose.tip, pose.points, pose.axes, pose.rotation


def in_parts(pose: ArmPose) -> tuple[list[Array], ...]:
    return (
        list(pose.tip_parts),
        [part for point in pose.point_parts for part in point],
        [part for axis in pose.axis_parts for part in axis],
    )


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize(
    ("many_q", "many_bases"),
    [((3, 4), (3, 4)), ((3, 4), ()), ((), (7,)), ((3, 1), (4,)), ((0,), ())],
)
def test_a_batch_is_the_same_as_one_by_one(
    name: str, many_q: tuple[int, ...], many_bases: tuple[int, ...]
) -> None:
    rng = np.random.default_rng(1)
    q = rng.normal(size=(*many_q, ROBOT[name].n))
    base = rng.normal(size=(*many_bases, 3))
    pose = KINEMATICS[name].forward(q, base)
    frames = KINEMATICS[name].frames(q, base)
    batch = np.broadcast_shapes(many_q, many_bases)
    assert [array.shape[: len(batch)] for array in made(pose)] == [batch] * 4
    for array, numbers in zip(made(pose)[:3], in_parts(pose), strict=True):
        for index, number in zip(np.ndindex(array.shape[len(batch) :]), numbers, strict=True):
            np.testing.assert_array_equal(array[(..., *index)], np.broadcast_to(number, batch))
    every_q, every_base = (
        np.broadcast_to(q, (*batch, q.shape[-1])),
        np.broadcast_to(base, (*batch, 3)),
    )
    for index in np.ndindex(batch):
        one = KINEMATICS[name].forward(every_q[index], every_base[index])
        for array, alone in zip(made(pose), made(one), strict=True):
            np.testing.assert_allclose(array[index], alone, atol=1e-12)
        alone = KINEMATICS[name].frames(every_q[index], every_base[index])
        np.testing.assert_allclose(frames[index], alone, atol=1e-12)


def oracle(model: pin.Model, robot: Robot, q: Array) -> pin.Data:
    """Pinocchio's view of the robot at those angles."""
    turn = np.zeros(model.nv)
    for joint, angle in zip(robot.joints, q, strict=True):
        turn[model.joints[model.getJointId(joint.name)].idx_v] = angle
    data = model.createData()
    pin.framesForwardKinematics(model, data, pin.integrate(model, pin.neutral(model), turn))
    return data


def assert_same(model: pin.Model, robot: Robot, tip: str, q: Array) -> None:
    """Compare every joint's frame, axis and point, and the tip, with Pinocchio's."""
    data = oracle(model, robot, q)
    pose, frames = Kinematics(robot).forward(q), Kinematics(robot).frames(q)
    for i, joint in enumerate(robot.joints):
        placement = data.oMi[model.getJointId(joint.name)]
        np.testing.assert_allclose(frames[i + 1], placement.homogeneous, atol=1e-9)
        point = placement.translation
        if joint.slides:  # its frame moves along the axis, which it began on
            point = point - q[i] * pose.axes[i]
        np.testing.assert_allclose(pose.points[i], point, atol=1e-9)
        np.testing.assert_allclose(pose.axes[i], placement.rotation @ joint.axis, atol=1e-9)
    placement = data.oMf[model.getFrameId(tip)]
    np.testing.assert_allclose(pose.tip, placement.translation, atol=1e-9)
    np.testing.assert_allclose(pose.rotation, placement.rotation, atol=1e-9)


TIPS = [("arph", "grip"), ("planar5", "tip"), ("seven", "tip"), ("telescope", "grip")]


@pytest.mark.parametrize(("name", "tip"), TIPS)
@given(data=st.data())
def test_our_robots_stand_where_pinocchio_says(name: str, tip: str, data: st.DataObject) -> None:
    model = MODELS[name]
    assert_same(model, ROBOT[name], tip, data.draw(joint_angles[name]))


MODELS = {name: pin.buildModelFromUrdf(str(ROBOTS / f"{name}.urdf")) for name in NAMES}


@pytest.mark.parametrize("name", NAMES)
def test_limits_are_read_as_pinocchio_reads_them(name: str) -> None:
    robot, model = ROBOT[name], MODELS[name]
    for i, joint in enumerate(robot.joints):
        theirs = model.joints[model.getJointId(joint.name)]
        assert robot.max_speed[i] == model.velocityLimit[theirs.idx_v]
        if np.isfinite(joint.upper):
            assert robot.lower[i] == model.lowerPositionLimit[theirs.idx_q]
            assert robot.upper[i] == model.upperPositionLimit[theirs.idx_q]


@settings(max_examples=50)
@given(
    st.lists(
        st.tuples(
            vectors,
            vectors,
            vectors.filter(lambda v: np.linalg.norm(v) > 0.1),
            st.sampled_from(["continuous", "prismatic", "fixed"]),
        ),
        min_size=1,
        max_size=7,
    ),
    st.data(),
)
def test_any_chain_stands_where_pinocchio_says(
    parts: list[tuple[Array, Array, Array, str]], data: st.DataObject
) -> None:
    text = "<robot name='any'><link name='link_0'/>"
    for i, (xyz, rpy, axis, kind) in enumerate(
        [*parts, (np.ones(3), np.ones(3), np.ones(3), "continuous")]
    ):
        words = [" ".join(map(repr, map(float, vector))) for vector in (xyz, rpy, axis)]
        text += (
            f"<link name='link_{i + 1}'/>"
            f"<joint name='joint_{i}' type='{kind}'>"
            f"<parent link='link_{i}'/><child link='link_{i + 1}'/>"
            f"<origin xyz='{words[0]}' rpy='{words[1]}'/><axis xyz='{words[2]}'/>"
            "<limit lower='-9' upper='9' velocity='1' effort='1'/></joint>"
        )
    text += "</robot>"
    with tempfile.NamedTemporaryFile("w", suffix=".urdf") as file:
        file.write(text)
        file.flush()
        robot = load(file.name)
    q = data.draw(arrays(float, robot.n, elements=angles))
    assert_same(pin.buildModelFromXML(text), robot, f"link_{len(parts) + 1}", q)


@given(st.tuples(*[st.floats(-1.0, 1.0)] * 4).filter(lambda q: np.linalg.norm(q) > 0.1))
def test_a_quaternion_survives_the_way_through_a_rotation_matrix(
    numbers: tuple[float, float, float, float],
) -> None:
    unit = np.array(numbers) / np.linalg.norm(numbers)
    back = quaternion(pin.Quaternion(unit).matrix())
    assert back[3] >= 0.0
    assert min(np.linalg.norm(back - unit), np.linalg.norm(back + unit)) < 1e-12


@pytest.mark.parametrize(
    ("rotation", "expected"),
    [
        (np.eye(3), [0, 0, 0, 1]),
        (np.diag([1.0, -1.0, -1.0]), [1, 0, 0, 0]),
        (np.diag([-1.0, 1.0, -1.0]), [0, 1, 0, 0]),
        (np.diag([-1.0, -1.0, 1.0]), [0, 0, 1, 0]),
        (np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]), [0, 0, np.sqrt(0.5), np.sqrt(0.5)]),
    ],
)
def test_half_and_quarter_turns_have_the_known_quaternions(
    rotation: Array, expected: list[float]
) -> None:
    np.testing.assert_allclose(np.abs(quaternion(rotation)), expected, atol=1e-15)


def test_quaternions_of_a_batch_are_those_of_one_by_one() -> None:
    q = np.random.default_rng(2).normal(size=(5, 2, 6))
    rotation = KINEMATICS["arph"].forward(q).rotation
    batch = quaternion(rotation)
    for index in np.ndindex(5, 2):
        np.testing.assert_allclose(batch[index], quaternion(rotation[index]), atol=1e-14)


def test_a_finger_that_follows_a_joint_of_the_arm_moves_with_it(tmp_path: Path) -> None:
    along_y, mimic = "<axis xyz='0 1 0'/>", "<mimic joint='slide' multiplier='-2' offset='0.5'/>"
    arm = urdf_texts.joint("j", "a", "b")
    arm += urdf_texts.joint("slide", "b", "c", along_y + urdf_texts.LIMIT, "prismatic")
    finger = urdf_texts.joint("finger", "b", "d", along_y + mimic, "prismatic")
    body = "<link name='d'><visual><geometry><sphere radius='0.1'/></geometry></visual></link>"
    content = urdf_texts.links("a", "b", "c") + body + arm + finger
    robot = load(urdf_texts.write(tmp_path, content), tip="c")
    (shape,) = robot.visuals
    assert [mimic.leader for mimic in robot.mimics] == [1]
    assert shape.frame == robot.n + 1
    frames = Kinematics(robot).frames(np.array([[0.0, 0.0], [0.0, 0.2]]))
    np.testing.assert_allclose(frames[:, shape.frame, :3, 3], [[0, 0.5, 0], [0, 0.1, 0]])
