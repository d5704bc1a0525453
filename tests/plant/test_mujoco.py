"""The plant with masses: where forces suffice it moves as the kinematic one does."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from plant.belt import Belt, Ranges
from plant.faults import Fault, FaultError
from plant.kinematic import KinematicPlant
from plant.kinematics import kinematics_of
from plant.plant import Commands, Plant, Setup, Truth
from plant.robot import Drive, Robot, RobotError
from plant.urdf import load
from plant.world import ObjectPath, WorldObject

mujoco = pytest.importorskip("mujoco", reason="needs MuJoCo: pip install 'msma[physics]'")
from plant.mujoco import MujocoPlant  # noqa: E402 - where it is installed

ARPH, SEVEN, TELESCOPE = load("arph"), load("seven"), load("telescope")
SIDEWAYS = Drive(
    kind="holonomic",
    max_linear=0.3,
    max_angular=0.8,
    max_linear_acceleration=0.5,
    max_angular_acceleration=2.0,
)
BENT = np.radians([0.0, 60.0, -115.0, 0.0, 0.0, 0.0])
LEVEL = np.zeros(6)  # stretched out
STARTS = {
    "arph": (ARPH, BENT, (0.2, 0.1, 0.3)),
    "seven": (SEVEN, np.radians([0.0, 40.0, 0.0, 60.0, 0.0, 40.0, 0.0]), None),
    "telescope": (TELESCOPE, np.array([0.3, 0.2, 0.1, 0.2, 0.3]), (0.2, 0.1, 0.3)),
}
MOVES = 0.2  # share of the full speeds that the open loop is commanded


def setup_of(name: str) -> Setup:
    robot, q, base = STARTS[name]
    return Setup(robot, q, base, period=0.02)


def arph(q: np.ndarray = BENT, *faults: str, **options: object) -> MujocoPlant:
    plant = MujocoPlant(Setup(ARPH, q, (0.0, 0.0, 0.0), period=0.02), **options)  # type: ignore[arg-type]
    for fault in faults:
        plant.inject(Fault.parse(fault, ARPH))
    return plant


def true(plant: Plant) -> Truth:
    truth = plant.truth()
    assert truth is not None
    return truth


def rest(plant: Plant, seconds: float) -> Truth:
    return run(plant, seconds, Commands((0.0,) * plant.robot.n, (0.0,) * plant.robot.base_speeds))


def run(plant: Plant, seconds: float, commands: Commands) -> Truth:
    for _ in range(round(seconds / plant.period)):
        plant.write(commands)
        plant.step()
    return true(plant)


def off(one: Truth, other: Truth) -> float:
    return float(np.linalg.norm(np.subtract(one.position, other.position)))


@pytest.mark.parametrize("base_model", ["planar", "wheels"])
def test_the_hand_starts_where_our_kinematics_say(base_model: str) -> None:
    plant = arph(base_model=base_model)
    expected = kinematics_of(ARPH).forward(BENT, np.zeros(3))
    np.testing.assert_allclose(true(plant).position, expected.tip, atol=1e-12)
    np.testing.assert_allclose(true(plant).rotation, expected.rotation.ravel(), atol=1e-12)


@pytest.mark.parametrize("name", STARTS)
def test_open_loop_it_follows_the_kinematic_plant(name: str) -> None:
    setup = setup_of(name)
    robot, rng = setup.robot, np.random.default_rng(1)
    base = MOVES * np.array(robot.drive.max_velocity if robot.drive else (0.0, 0.0))
    plants = [KinematicPlant(setup), MujocoPlant(setup)]
    worst = 0.0
    for _ in range(4):
        speeds = MOVES * robot.max_speed * rng.uniform(-1.0, 1.0, robot.n)
        one, other = (run(plant, 0.5, Commands(speeds, base)) for plant in plants)
        worst = max(worst, off(one, other))
        base = -base
    assert worst < 0.005  # [m]: the servos lag by some milliseconds at every change


def test_the_mass_of_arph_is_that_of_its_shapes_at_the_density_of_water() -> None:
    model = arph()._model
    volume = 0.0
    for shape in ARPH.visuals:
        match shape.kind:
            case "box":
                volume += math.prod(shape.size)
            case "cylinder":
                volume += math.pi * shape.size[0] ** 2 * shape.size[1]
            case "sphere":
                volume += 4.0 / 3.0 * math.pi * shape.size[0] ** 3
    assert model.body_mass.sum() == pytest.approx(1000.0 * volume)
    assert arph(base_model="wheels")._model.body_mass.sum() == pytest.approx(1000.0 * volume)


def test_a_mass_of_the_description_counts_in_place_of_its_shapes() -> None:
    plant = MujocoPlant(setup_of("telescope"))
    assert TELESCOPE.gripper is not None
    fingers = [link for each in TELESCOPE.gripper.fingers for link in each.links]  # without any
    shapes = sum(1000.0 * math.prod(x.size) for x in TELESCOPE.visuals if x.link in fingers)
    total = sum(x.mass for x in TELESCOPE.inertials) + shapes
    assert plant._model.body_mass.sum() == pytest.approx(total)


@pytest.mark.parametrize("name", STARTS)
def test_the_torques_that_hold_an_arm_are_the_gradient_of_its_potential_energy(name: str) -> None:
    setup = setup_of(name)
    plant = MujocoPlant(setup)
    rest(plant, 0.5)
    force = plant._data.actuator_force[plant._servos._motors]
    model, data = plant._model, mujoco.MjData(plant._model)

    def energy(q: np.ndarray) -> float:
        data.qpos[:] = plant._data.qpos
        data.qpos[plant._servos.q] = q
        mujoco.mj_forward(model, data)
        return float(9.81 * model.body_mass @ data.xipos[:, 2])

    q, small = plant._data.qpos[plant._servos.q].copy(), 1e-5
    steps = small * np.eye(setup.robot.n)
    gradient = [(energy(q + step) - energy(q - step)) / (2.0 * small) for step in steps]
    np.testing.assert_allclose(force, gradient, atol=0.02)
    assert np.abs(gradient).max() > 1.0  # [N m] or [N]: there is something to hold


def test_without_gravity_compensation_the_arm_sinks() -> None:
    held = rest(arph(LEVEL), 1.0).position[2]
    assert held == pytest.approx(0.8375, abs=1e-4)
    assert rest(arph(LEVEL, gravity_compensation=False), 1.0).position[2] < held - 0.001


def test_a_limp_shoulder_falls_and_works_again() -> None:
    plant = arph(LEVEL, "joint/2:limp")
    assert rest(plant, 1.0).q[1] < math.radians(-20.0)
    plant.inject(Fault.parse("joint/2:ok", ARPH))
    stopped = rest(plant, 0.5).q[1]
    assert run(plant, 1.0, Commands((0.0, 0.5, 0.0, 0.0, 0.0, 0.0))).q[1] > stopped + 0.3


def test_a_weak_shoulder_cannot_lift_what_a_whole_one_lifts() -> None:
    lift = Commands((0.0, 0.4, 0.0, 0.0, 0.0, 0.0))
    assert run(arph(LEVEL), 1.0, lift).q[1] > 0.3
    assert run(arph(LEVEL, "joint/2:weak=0.2"), 1.0, lift).q[1] < 0.0


def test_a_locked_joint_stays_whatever_it_carries() -> None:
    plant = arph(LEVEL, "joint/2:locked", "payload:added=3kg")
    assert run(plant, 1.0, Commands((0.5,) * 6)).q[1] == pytest.approx(0.0, abs=1e-3)


def test_a_joint_that_is_locked_at_an_angle_goes_there() -> None:
    plant = arph(BENT, "joint/1:locked=30deg")
    assert rest(plant, 2.0).q[0] == pytest.approx(math.radians(30.0), abs=1e-3)


@pytest.mark.parametrize("base_model", ["planar", "wheels"])
def test_a_locked_platform_withstands_a_push(base_model: str) -> None:
    plant = arph(BENT, "platform:locked", "hand:push_x=-30N", base_model=base_model)
    truth = rest(plant, 1.0)
    np.testing.assert_allclose(truth.base, 0.0, atol=2e-3)


def test_encoders_and_the_localiser_fail_as_in_the_kinematic_plant() -> None:
    plant = arph(BENT, "encoder/2:biased=5deg", "encoder/3:lost", "localiser:lost")
    truth, seen = true(plant), plant.read()
    assert seen.q[1] == pytest.approx(truth.q[1] + math.radians(5.0))
    assert math.isnan(seen.q[2])
    assert (seen.position, seen.rotation) == (None, None)


def test_a_runaway_joint_moves_at_random() -> None:
    assert abs(rest(arph(BENT, "joint/1:runaway=0.5"), 1.0).q[0]) > 1e-3


def test_a_push_moves_the_hand_along_it_while_it_lasts() -> None:
    plant = arph()
    before = true(plant).position
    plant.inject(Fault.parse("hand:push_y=30N", ARPH))
    pushed = rest(plant, 0.5).position
    assert pushed[1] > before[1] + 0.002
    plant.inject(Fault.parse("hand:ok", ARPH))
    after = rest(plant, 0.1)
    assert off(rest(plant, 0.5), after) < 1e-3


def test_a_payload_weighs_at_the_hand() -> None:
    plant = arph(LEVEL, "payload:added=1.5kg")
    empty, laden = rest(arph(LEVEL), 0.2).position[2], rest(plant, 0.2).position[2]
    assert laden < empty - 1e-3
    plant.inject(Fault.parse("payload:ok", ARPH))
    assert plant._model.body_mass.sum() == pytest.approx(arph()._model.body_mass.sum())


def test_the_kinematic_plant_refuses_forces_and_says_who_takes_them() -> None:
    plant = KinematicPlant(setup_of("arph"))
    with pytest.raises(FaultError, match="knows no forces"):
        plant.inject(Fault.parse("hand:push_x=30N", ARPH))


def test_a_robot_on_wheels_drives_where_a_planar_one_does() -> None:
    commands = Commands((0.0,) * 6, (0.2, 0.3))
    planar, rolling = (run(arph(base_model=model), 2.0, commands) for model in ("planar", "wheels"))
    np.testing.assert_allclose(rolling.base, planar.base, atol=0.01)
    np.testing.assert_allclose(rolling.base_velocity, (0.2, 0.3), atol=0.005)


def test_an_arm_that_falls_on_a_table_lies_on_it_with_its_weight() -> None:
    plant = with_objects(box("table", 0.7, 0.6, y=-0.18, fixed=True), q=LEVEL)
    plant.inject(Fault.parse("joint/2:limp", ARPH))
    rest(plant, 1.0)
    plant.close()
    plant.touches()
    rest(plant, 0.5)
    plant.close()
    (touch,) = plant.touches()
    assert (touch.body, touch.other, touch.of_robot) == ("hand", "table", True)
    # about the shoulder, the table pushes up what gravity pulls down
    model, data, joint = plant._model, plant._data, plant._servos._joints[1]
    body = model.jnt_bodyid[joint]
    anchor, com = data.xanchor[joint], data.subtree_com[body]
    turning = 9.81 * model.body_subtreemass[body] * (com - anchor)[0]
    assert 0.5 < touch.mean * (0.7 - anchor[0]) / turning < 1.5
    assert touch.force >= touch.mean


def test_a_contact_of_the_robot_is_told_once_with_its_largest_force() -> None:
    plant = with_objects(box("wall", 0.7, 0.2, fixed=True))
    run(plant, 2.0, Commands((0.0,) * 6, (0.3, 0.0)))
    assert plant.contacts() == ()  # it goes on
    plant.close()
    (contact,) = plant.contacts()
    assert (contact.part, contact.object) == ("platform", "wall")
    assert 0.0 < contact.t < 2.0
    assert contact.force is not None
    assert contact.force > 10.0
    assert plant.contacts() == ()


def test_free_motion_is_no_contact() -> None:
    plant = arph(base_model="wheels")
    run(plant, 1.0, Commands((0.1,) * 6, (0.1, 0.1)))
    plant.close()
    assert plant.touches() == []


@pytest.mark.parametrize(
    ("robot", "options", "message"),
    [
        (ARPH, {"time_step": 0.0}, "time_step: 0 s must be above 0"),
        (ARPH, {"time_step": 1.0}, "at most the control period, 0.02 s"),
        (ARPH, {"servo_gain": -1.0}, "servo_gain: -1 must be positive"),
        (SEVEN, {"base_model": "wheels"}, "base_model: robot 'seven' has no platform with wheels"),
        (TELESCOPE, {"base_model": "wheels"}, "base_model: no sphere of the base touches"),
        (replace(ARPH, drive=SIDEWAYS), {"base_model": "wheels"}, "base_model: a holonomic base"),
    ],
)
def test_an_option_that_makes_no_sense_is_refused(
    robot: Robot, options: dict[str, float | str], message: str
) -> None:
    start = np.clip(np.zeros(robot.n), robot.lower, robot.upper)
    with pytest.raises(ValueError, match=message):
        MujocoPlant(Setup(robot, start, period=0.02), **options)  # type: ignore[arg-type]


def test_it_simulates_one_robot_only() -> None:
    with pytest.raises(RobotError, match="not a batch"):
        MujocoPlant(Setup(SEVEN, np.zeros((3, 7)), period=0.02))


def box(name: str, x: float, z: float, y: float = 0.0, **options: object) -> WorldObject:
    """A cube of 0.2 m with its centre there [m]."""
    cube = (0.2, 0.2, 0.2)
    return WorldObject(name=name, box=cube, position=(x, y, z), **options)  # type: ignore[arg-type]


def with_objects(*world: WorldObject, q: np.ndarray = BENT) -> MujocoPlant:
    return MujocoPlant(Setup(ARPH, q, (0.0, 0.0, 0.0), period=0.02, world=world))


def test_a_box_that_is_dropped_weighs_what_it_weighs_on_what_it_falls_on() -> None:
    plant = with_objects(box("table", 2.0, 0.1, fixed=True), box("cup", 2.0, 0.4, mass=0.3))
    rest(plant, 2.0)
    plant.close()
    plant.touches()
    rest(plant, 0.5)
    plant.close()
    (contact,) = plant.touches()
    assert (contact.body, contact.other, contact.of_robot) == ("table", "cup", False)
    assert contact.mean == pytest.approx(0.3 * 9.81, rel=0.01)


def test_what_the_platform_drives_into_is_touched_and_pushed_away() -> None:
    plant = with_objects(box("crate", 0.7, 0.2, mass=5.0))
    run(plant, 2.0, Commands((0.0,) * 6, (0.3, 0.0)))
    plant.close()
    touched = [each for each in plant.touches() if each.of_robot]
    assert {(each.body, each.other) for each in touched} == {("platform", "crate")}
    assert max(each.force for each in touched) > 1.0
    assert plant._data.body("object crate").xpos[0] > 0.9


def test_a_platform_does_not_get_past_a_fixed_wall() -> None:
    plant = with_objects(box("wall", 0.7, 0.2, fixed=True))
    assert run(plant, 1.5, Commands((0.0,) * 6, (0.3, 0.0))).base[0] < 0.2


def test_what_moves_by_itself_is_where_its_path_says_and_pushes_the_hand_aside() -> None:
    x, y, z = kinematics_of(ARPH).forward(BENT, np.zeros(3)).tip
    points = ((x, y + 0.6, z), (x, y + 0.1, z))
    path = ObjectPath(points=points, speed=0.5)
    person = WorldObject(name="person", sphere=0.1, path=path)
    plant = with_objects(person)
    before = rest(plant, 0.1).position
    after = rest(plant, 1.2).position
    np.testing.assert_allclose(plant._data.body("object person").xpos, points[1], atol=1e-9)
    assert after[1] < before[1] - 0.01
    plant.close()
    assert ("hand", "person") in {(each.body, each.other) for each in plant.touches()}


def test_a_holonomic_base_also_moves_sideways() -> None:
    plant = MujocoPlant(Setup(replace(ARPH, drive=SIDEWAYS), BENT, (0.0,) * 3, period=0.02))
    truth = run(plant, 2.0, Commands((0.0,) * 6, (0.0, 0.0, 0.2)))
    assert truth.base[1] > 0.3
    np.testing.assert_allclose(truth.base_velocity, (0.0, 0.0, 0.2), atol=1e-3)


CORNER = """
v 0 0 0
v 1 0 0
v 0 1 0
v 0 0 1
f 1 3 2
f 1 2 4
f 1 4 3
f 2 3 4
"""  # of a cube: a sixth of it


def with_mesh(folder: Path, name: str) -> Robot:
    """An arm of one joint and one mesh, scaled to 0.3 m, in a package that has both."""
    mesh = f'<geometry><mesh filename="{name}" scale="0.3 0.3 0.3"/></geometry>'
    (folder / "package" / "urdf").mkdir(parents=True, exist_ok=True)
    file = folder / "package" / "urdf" / "arm.urdf"
    file.write_text(
        f"""<robot name="arm"><link name="base"/>
        <joint name="turn" type="continuous">
          <parent link="base"/><child link="arm"/><limit velocity="1"/>
        </joint>
        <link name="arm"><collision>{mesh}</collision></link></robot>"""
    )
    return load(file)


@pytest.mark.parametrize("name", ["package://package/meshes/one.obj", "../meshes/one.obj"])
def test_a_mesh_has_its_volume(tmp_path: Path, name: str) -> None:
    (tmp_path / "package" / "meshes").mkdir(parents=True)
    (tmp_path / "package" / "meshes" / "one.obj").write_text(CORNER)
    plant = MujocoPlant(Setup(with_mesh(tmp_path, name), (0.0,), period=0.02))
    assert plant._model.body("1 arm").mass[0] == pytest.approx(1000.0 * 0.3**3 / 6.0, rel=1e-4)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("package://package/one.stl", "link 'arm': there is no mesh package://package/one.stl"),
        ("arm.urdf", "link 'arm': MuJoCo cannot read the mesh"),
        ("text.stl", "MuJoCo cannot use robot 'arm': .*text.stl"),
    ],
)
def test_a_mesh_that_cannot_be_used_is_refused(tmp_path: Path, name: str, message: str) -> None:
    robot = with_mesh(tmp_path, name)
    (tmp_path / "package" / "urdf" / "text.stl").write_text("solid text\nendsolid text\n")
    with pytest.raises(RobotError, match=message):
        MujocoPlant(Setup(robot, (0.0,), period=0.02))


def ranges(plant: Plant) -> tuple[float, ...]:
    reading = plant.read().sensors["ranges"]
    assert isinstance(reading, Ranges)
    return reading.ranges


def test_the_belt_sees_a_box_where_the_physics_have_moved_it() -> None:
    robot = replace(ARPH, belt=Belt(sensors=5, height=0.1, noise=0.0, dropouts=0.0))
    world = (box("crate", 2.0, 0.3, mass=2.0),)
    plants = [kind(Setup(robot, BENT, (0.0,) * 3, period=0.02, world=world)) for kind in
              (MujocoPlant, KinematicPlant)]  # fmt: skip
    rest_of = [rest(plant, 0.5) for plant in plants]  # it falls to the floor
    one, other = map(ranges, plants)
    assert rest_of[0].t == rest_of[1].t
    np.testing.assert_allclose(one, other, atol=0.005)
    assert min(one) < 1.5
