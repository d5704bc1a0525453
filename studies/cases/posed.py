"""Arms of all kinds that move their hands to random poses, and after moving ones; long chains."""

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np

from agents.agent import Agent, Array, Body, Goal
from agents.joint import JointAgent
from agents.kick import ranges
from agents.markers import aim_at, angle_off
from agents.platform import PlatformAgent
from plant.kinematic import KinematicPlant
from plant.kinematics import kinematics_of, quaternion
from plant.packages import find
from plant.plant import Commands, Setup
from plant.robot import Drive, Robot
from plant.urdf import load
from studies.baselines.central import as_agents
from studies.baselines.pose_ik import DampedLeastSquares
from studies.batch_faults import BatchFaults, BatchPlant
from studies.lockstep import Trace, run
from studies.mobile import BEARING
from studies.mobile_reach import Bools
from studies.no_model import planar

NEAR, TURNED = 0.003, np.radians(1.0)
"""Tolerance [m], [rad]."""
PERIOD, DURATION = 0.02, 30.0
"""Of runs to poses that stand [s]."""
EVERY = 5
"""One tick of those out of so many is judged."""
LAST = 1.0
"""The last part of a run, in which a hand must stay within tolerance [s]."""
AROUND = 1.5
"""How far from where it starts a platform is at most in the posture of a goal [m]."""
SPEED, TURNING = 0.07, np.radians(10.0)
"""Of a moving pose [m/s], [rad/s]."""
FOLLOWING, SETTLED = 6.0, 2.0
"""How long one moves, and from when on errors count [s]."""
ORACLE, EXACT, FAST = 0.06, 1e-3, 1 / 3
"""Period of the oracle [s], its damping, and the share of its top speed that no joint of it is to
exceed: beyond that a posture is nearly singular."""
CHAIN_PERIOD, CHAIN_DURATION, CHAIN_NEAR = 0.06, 20.0, 0.001
"""Of chains [s], [s], [m]."""
DATA, STRETCH = "example-robot-data", "hello-robot-stretch-urdf"


class Source(NamedTuple):
    """Where a robot is described.

    Attributes:
        name: For people.
        package: The installed package that has the file; empty for a robot that comes with MSMA.
        file: The file in that package, or the bare name of the robot.
        tip: The link whose frame is the hand; None for the end of the longest chain.
        base: What moves the base; None for what the file says.
    """

    name: str
    package: str
    file: str
    tip: str | None = None
    base: Drive | None = None

    def load(self) -> Robot:
        """Return the robot, or raise `RobotError` if its package is not installed."""
        file = find(self.package, self.file) if self.package else self.file
        return load(file, tip=self.tip, base=self.base)


UR5 = Source("UR5", DATA, "ur_description/urdf/ur5_robot.urdf", "tool0")
SOURCES = (
    UR5,
    Source("Panda", DATA, "panda_description/urdf/panda.urdf", "panda_hand_tcp"),
    Source("Jaco", DATA, "kinova_description/robots/kinova.urdf", "j2s6s200_end_effector"),
    Source("xArm7", DATA, "xarm_description/urdf/xarm7.urdf", "link_eef"),
    Source("TIAGo", DATA, "tiago_description/robots/tiago.urdf", "hand_tool_link"),
    Source("Stretch", STRETCH, "SE3/stretch_description_SE3_eoa_wrist_dw3_tool_sg3.urdf",
           "link_grasp_center"),
    Source("ARPH", "", "arph"),
    Source("seven", "", "seven"),
    Source("telescope", "", "telescope", base=Drive(kind="fixed")),
)  # fmt: skip
"""Public robots, and those that come with MSMA; ARPH drives, the others are bolted."""


class Task(NamedTuple):
    """What hands are to do.

    Attributes:
        name: For people.
        bar: The share of them that have to.
        turns: Whether their orientation matters.
        locked: Whether one joint of each arm is locked, where it is in the goal's posture too.
    """

    name: str
    bar: float
    turns: bool = True
    locked: bool = False


TASKS = (
    Task("pose", 0.95),
    Task("position only", 0.99, turns=False),
    Task("pose, one joint locked", 0.90, locked=True),
)


class Posed(NamedTuple):
    """B arms of one robot and their goals, which some posture reaches.

    Attributes:
        robot: The robot.
        q: (B, n) joint positions at the start [rad or m].
        goal: Of each.
        locked: (B, n) which joints are locked.
    """

    robot: Robot
    q: Array
    goal: Goal
    locked: Bools


def posed(robot: Robot, task: Task, count: int, seed: int) -> Posed:
    """Return arms in random postures, with goals where the hand is in other random postures."""
    rng = np.random.default_rng([seed, 7])
    low, high = ranges(robot)
    q, there = (rng.uniform(low, high, (count, robot.n)) for _ in range(2))
    locked = np.zeros(q.shape, dtype=bool)
    if task.locked:
        locked[np.arange(count), rng.integers(0, robot.n, count)] = True
        there = np.where(locked, q, there)
    base = np.zeros((count, 3))
    if robot.drive is not None:
        course, heading = rng.uniform(-np.pi, np.pi, (2, count))
        radius = AROUND * np.sqrt(rng.random(count))
        base = np.stack([radius * np.cos(course), radius * np.sin(course), heading], axis=1)
    hand = kinematics_of(robot).forward(there, base)
    turn = quaternion(hand.rotation) if task.turns else None
    goal = Goal(hand.tip, np.zeros((count, 3)), 0.0, 0.0, turn)
    return Posed(robot, q, goal, locked)


def team(
    robot: Robot, period: float, seed: int, platform: type[PlatformAgent] = PlatformAgent
) -> dict[str, Agent]:
    """Return MSMA's agents by role; on a platform with the options of ARPH's in deploy/arph.yaml.

    Args:
        robot: The robot.
        period: Control period [s].
        seed: Of their random numbers.
        platform: Class of the platform's agent, if there is one.
    """
    drives = robot.drive is not None
    agents: dict[str, Agent] = {
        f"joint/{i + 1}": JointAgent(
            Body(robot, i, period, [seed, i]),
            perception="blackboard",
        )
        for i in range(robot.n)
    }
    if drives:
        body = Body(robot, None, period, [seed, robot.n])
        agents["platform"] = platform(body, perception="blackboard", bearing=BEARING)
    return agents


def play(arms: Posed, agents: Mapping[str, Agent], seed: int) -> Trace:
    """Run all arms as one batch, in lockstep.

    Args:
        arms: The arms.
        agents: By role.
        seed: Of what is random in the plant.
    """
    each = BatchFaults.none(arms.robot, len(arms.q))
    each.strength[arms.locked] = 0.0
    plant = BatchPlant(Setup(arms.robot, arms.q, period=PERIOD, seed=[seed]), each)
    return run(plant, agents, lambda t: arms.goal, DURATION, every=EVERY)


def settled(arms: Posed, trace: Trace) -> Array:
    """Return from when on each hand stays within tolerance to the end (B,) [s].

    It is infinite where that is less than `LAST` before the end.
    """
    angle = angles_off(arms.robot, arms.goal, trace)
    return to_the_end(trace.t, (trace.error < NEAR) & (angle < TURNED))


def to_the_end(t: Array, good: Bools) -> Array:
    """Return from when on each of B runs stays good, (K, B), to the end (B,) [s]."""
    bad = ~good[::-1]
    after = np.where(bad.any(axis=0), len(t) - bad.argmax(axis=0), 0)
    since = np.append(t, np.inf)[after]
    found: Array = np.where(since <= t[-1] - LAST, since, np.inf)
    return found


def angles_off(robot: Robot, goal: Goal, trace: Trace) -> Array:
    """Return by how much the hands of a trace are turned against their goals (K, B) [rad]."""
    angles = np.zeros(trace.error.shape)
    for row, t, q, base in zip(angles, trace.t, trace.q, trace.base, strict=True):
        turn = quaternion(kinematics_of(robot).forward(q, base).rotation)
        x, y, z, w = np.moveaxis(turn, -1, 0)
        row[:] = angle_off(np, (w, x, y, z), aim_at(np, goal, float(t)))
    return angles


class Moving(NamedTuple):
    """B arms with goals that move from where their hands are, shapes as of `Posed`."""

    robot: Robot
    q: Array
    goal: Goal

    def part(self, rows: Bools) -> "Moving":
        """Return some of them."""
        place, velocity, since, until, turn, rate, *_ = self.goal
        assert turn is not None
        assert rate is not None
        goal = Goal(place[rows], velocity[rows], since, until, turn[rows], rate[rows])
        return Moving(self.robot, self.q[rows], goal)


def moving(robot: Robot, count: int, seed: int) -> Moving:
    """Return arms with goals that move and turn all ways, of those that an oracle can follow.

    The oracle is `DampedLeastSquares`: within a third of the tolerance after `SETTLED`, no joint
    faster than `FAST`.

    Args:
        robot: The robot.
        count: Number of goals, of which some can be followed.
        seed: Of the goals.
    """
    rng = np.random.default_rng([seed, 8])
    q = rng.uniform(*ranges(robot), (count, robot.n))
    hand = kinematics_of(robot).forward(q)
    velocity, rate = rng.normal(size=(2, count, 3))
    velocity *= SPEED / np.linalg.norm(velocity, axis=1, keepdims=True)
    rate *= TURNING / np.linalg.norm(rate, axis=1, keepdims=True)
    goal = Goal(hand.tip, velocity, 0.0, 2 * FOLLOWING, quaternion(hand.rotation), rate)
    arms = Moving(robot, q, goal)
    oracle = DampedLeastSquares(robot, ORACLE, damping=EXACT)
    distance, angle, speed = follow(arms, as_agents(oracle, robot), ORACLE, seed)
    return arms.part((distance < NEAR / 3) & (angle < TURNED / 3) & (speed < FAST))


def follow(
    arms: Moving, agents: Mapping[str, Agent], period: float, seed: int
) -> tuple[Array, Array, Array]:
    """Return the largest errors after `SETTLED` and the largest speed of any joint, (B,) each.

    Args:
        arms: The arms.
        agents: By role.
        period: Control period [s].
        seed: Of what is random in the plant.

    Returns:
        The distance [m], the angle [rad], and the speed as a share of the top speed.
    """
    plant = KinematicPlant(Setup(arms.robot, arms.q, period=period, seed=[seed]))
    every = max(round(PERIOD / 2 / period), 1)
    trace = run(plant, agents, lambda t: arms.goal, FOLLOWING, every=every)
    counts = trace.t > SETTLED
    angle = angles_off(arms.robot, arms.goal, trace)[counts].max(axis=0)
    speed = (np.abs(trace.qd) / arms.robot.max_speed).max(axis=(0, 2))
    return trace.error[counts].max(axis=0), angle, speed


class LatePlant(KinematicPlant):
    """The kinematic plant, which takes each command a period late."""

    def __init__(self, setup: Setup) -> None:
        """Begin at rest, with no command on its way."""
        super().__init__(setup)
        self._before = Commands(np.zeros(setup.robot.n))

    def write(self, commands: Commands) -> None:
        """Apply the commands of the period before."""
        super().write(self._before)
        self._before = commands


def chain(joints: int, late: bool, count: int, seed: int) -> Trace:
    """Run planar arms to goals that stand, for `CHAIN_DURATION`, as one batch, in lockstep.

    The arms are 1 m long, of equal links without stops, and bent at random; their goals are
    anywhere within 0.9 m.

    Args:
        joints: Number of joints.
        late: Whether commands act a period later.
        count: Number of arms.
        seed: Of postures and goals.
    """
    robot = planar(joints)
    rng = np.random.default_rng([seed, joints])
    q = rng.uniform(-2.5, 2.5, (count, joints)) / np.sqrt(joints)
    radius, course = 0.9 * np.sqrt(rng.random(count)), rng.uniform(-np.pi, np.pi, count)
    place = np.stack([radius * np.cos(course), radius * np.sin(course), 0.0 * course], axis=1)
    goal = Goal(place, np.zeros((count, 3)), 0.0, 0.0)
    setup = Setup(robot, q, period=CHAIN_PERIOD, seed=[seed])
    plant = LatePlant(setup) if late else KinematicPlant(setup)
    return run(plant, team(robot, CHAIN_PERIOD, seed), lambda t: goal, CHAIN_DURATION)


def arrived(trace: Trace) -> Array:
    """Return from when on the hands of such arms stay at their goals to the end (B,) [s]."""
    return to_the_end(trace.t, trace.error < CHAIN_NEAR)
