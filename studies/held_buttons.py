"""A person who holds one button of the page after the other, with the robot in lockstep."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from agents.agent import Agent, Array, Body, Goal, Percepts
from agents.attitude import turn_between
from agents.joint import JointAgent
from agents.platform import PlatformAgent
from nodes.hmi.jogging import Hand, Motion, joint_index, level_axes
from nodes.hmi.leading import LedGoal
from nodes.hmi.protocol.values import Times
from plant.faults import Fault
from plant.kinematic import KinematicPlant
from plant.kinematics import kinematics_of, quaternion
from plant.plant import Setup
from plant.robot import numbers
from runtime.gate.speed_limit import SpeedLimit
from studies.lockstep import decide_all, true_motion
from studies.mobile import ARPH, BEND, PERIOD

ASIDE = np.radians(90.0)
"""Bearing of the hand when lined up, in deploy/arph-web.yaml [rad]."""
SIDES = {
    "forward": (1.0, 0.0, 0.0),
    "left": (0.0, 1.0, 0.0),
    "back": (-1.0, 0.0, 0.0),
    "right": (0.0, -1.0, 0.0),
    "up": (0.0, 0.0, 1.0),
    "down": (0.0, 0.0, -1.0),
}
"""Directions of the buttons: ahead, to the left and up for the person."""
HOLDS = 30.0
"""For how long the person holds a button at most [s]."""
STANDS, BARELY = 6.0, 0.002
"""A hand that has not gone so far [m] in that time [s] stands, and the person lets go."""
RESTS = 1.0
"""From one button to the next [s]."""
CHORD = 0.04
"""Length of way whose direction counts [m]: 20 mm to the side of that are 30 deg."""


class Square(NamedTuple):
    """A square that is drawn.

    Attributes:
        q: Joint angles at the start [rad].
        heading: Of the platform at the start [rad].
        camera: Heading of the person's view [rad].
        buttons: In their order.
        side: Length of each side [m].
        speed: Of the buttons [m/s].
        breaks: When the faults begin, in time that buttons have been held [s].
    """

    q: Array
    heading: float
    camera: float
    buttons: Sequence[str]
    side: float
    speed: float
    breaks: float


class Side(NamedTuple):
    """What came of one side.

    Attributes:
        button: Which was held.
        along: How far the hand went its way [m].
        beside: How far it was beside the line of the button, until it rested [m].
        turned: The largest angle between a chord of its way and that line [rad].
        tilted: By how much the hand turned [rad].
        took: For how long the button was held [s].
        in_reach: Whether the joints that still move can have the hand as high as its end is. The
            platform can bring it to any place at that height.
    """

    button: str
    along: float
    beside: float
    turned: float
    tilted: float
    took: float
    in_reach: bool


def drawn(count: int, seed: int) -> list[Square]:
    """Return squares of all postures, planes, ways round and speeds, drawn from a seed."""
    rng = np.random.default_rng(seed)
    squares = []
    for _ in range(count):
        low = np.radians([-60.0, 40.0, -140.0, -30.0, -30.0, 0.0])
        q = rng.uniform(low, np.radians([60.0, 80.0, -90.0, 30.0, 30.0, 0.0]))
        heading, camera = rng.uniform(-np.pi, np.pi, 2)
        first = rng.choice(["forward", "up"])
        buttons = [first, "left", {"forward": "back", "up": "down"}[first], "right"]
        buttons = np.roll(buttons[:: rng.choice([1, -1])], rng.integers(4)).tolist()
        speed, breaks = rng.choice([0.05, 0.1, 0.15]), rng.uniform(0.5, 2.0)
        squares.append(Square(q, heading, camera, buttons, 0.2, float(speed), breaks))
    return squares


def web_team(seed: int) -> dict[str, Agent]:
    """Return the agents of deploy/arph-web.yaml, but that of the gripper."""
    agents: dict[str, Agent] = {}
    for joint in range(ARPH.n):
        body = Body(ARPH, joint, PERIOD, [seed, joint])
        agents[f"joint/{joint + 1}"] = JointAgent(body, bend=BEND.get(joint, 0.0))
    agents["platform"] = PlatformAgent(Body(ARPH, None, PERIOD, [seed, ARPH.n]), bearing=ASIDE)
    return agents


class Driven:
    """A robot that a person drives in shared mode.

    The page's goal goes by the last but one state, and the gate by its speed limit.

    Args:
        square: What is drawn.
        faults: In their text form, and roles of agents to kill.
        seed: Of all random numbers.
    """

    def __init__(self, square: Square, faults: Sequence[str], seed: int) -> None:
        base = np.array([0.0, 0.0, square.heading])
        self._plant = KinematicPlant(Setup(ARPH, square.q, base, period=PERIOD, seed=[seed, 1000]))
        self._agents, self._limit = web_team(seed), SpeedLimit(ARPH, PERIOD)
        self._square, self._faults, self._held = square, list(faults), 0.0
        broken = [joint_index(fault.partition(":")[0], ARPH.n) for fault in faults]
        self._broken = [joint for joint in broken if joint is not None]
        self._times = Times()

    def _hand(self) -> Hand:
        truth = true_motion(self._plant)
        turned = np.reshape(np.array(truth.rotation), (3, 3))
        return Hand(np.array(truth.position), quaternion(turned))

    def side(self, button: str) -> Side:
        """Hold a button until the hand has gone the side, or stands; then let it come to rest."""
        square, start = self._square, self._hand()
        direction = np.array(SIDES[button]) @ level_axes(square.camera)
        motion = Motion(square.speed * direction, np.zeros(3))
        led = LedGoal(start, 0.0, self._times.lease)
        looks = round(STANDS / PERIOD)
        hands, along, page = [start], [0.0], 0.0
        while along[-1] < square.side and len(hands) * PERIOD < HOLDS:
            if len(along) > looks and along[-1] - along[-1 - looks] < BARELY:
                break
            t, now = self._plant.read().t, (len(hands) - 1) * PERIOD
            while page <= now + 1e-9:
                piece = led.advance(motion, hands[max(len(hands) - 2, 0)], page)
                since = t + page - now
                page += self._times.jog
            self._break()
            pose, (linear, angular) = piece.pose, piece.motion
            until = since + piece.lasts
            self._step(Goal(pose.position, linear, since, until, pose.orientation, angular), 1.0)
            hands.append(self._hand())
            along.append(float((hands[-1].position - start.position) @ direction))
        took = (len(hands) - 1) * PERIOD
        for _ in range(round(RESTS / PERIOD)):
            here, t = hands[-1], self._plant.read().t
            self._step(Goal(here.position, np.zeros(3), t, t, here.orientation), 0.0)
            hands.append(self._hand())
        way = np.array([hand.position for hand in hands]) - start.position
        beside = np.linalg.norm(way - np.outer(way @ direction, direction), axis=1)
        tilts = [turn_between(start.orientation, hand.orientation) for hand in hands]
        tilted = float(np.linalg.norm(tilts, axis=1).max())
        turned = largest_turn(way, direction)
        drawn = max(along) >= square.side
        reach = drawn or self._reaches(start.position[2] + square.side * direction[2])
        return Side(button, max(along), float(beside.max()), turned, tilted, took, reach)

    def _reaches(self, height: float) -> bool:
        """Tell whether the joints that still move can have the hand at a height [m]."""
        low, high = heights(numbers(self._plant.read().q), self._broken)
        return low <= height <= high

    def _break(self) -> None:
        self._held += PERIOD
        if self._held > self._square.breaks:
            while self._faults:
                fault = self._faults.pop()
                if self._agents.pop(fault, None) is None:
                    self._plant.inject(Fault.parse(fault, ARPH))

    def _step(self, goal: Goal, share: float) -> None:
        """Let agents decide, and the plant move; of their speeds the gate lets a share through."""
        readings = self._plant.read()
        percepts = Percepts.of(readings, goal)
        wanted = decide_all(self._agents, percepts, (ARPH.n,))
        wanted = wanted._replace(joints=numbers(wanted.joints), base=numbers(wanted.base))
        q, limit = numbers(readings.q), self._square.speed
        self._plant.write(self._limit.limited(wanted, q, limit, share))
        self._plant.step()


def heights(q: Sequence[float], broken: Sequence[int]) -> tuple[float, float]:
    """Return the lowest and the highest hand [m] of an arm of which some joints do not move.

    Those that do are sampled every 15 degrees, within half a turn where they are endless.

    Args:
        q: Joint angles [rad].
        broken: Indices of the joints that keep theirs; the column and the hand's roll do not count.
    """
    angles = [np.array([angle]) for angle in q]
    for i in {1, 2, 3, 4} - set(broken):
        low, high = max(ARPH.joints[i].lower, -np.pi), min(ARPH.joints[i].upper, np.pi)
        angles[i] = np.append(np.arange(low, high, np.radians(15.0)), high)
    postures = np.stack(np.meshgrid(*angles), axis=-1).reshape(-1, ARPH.n)
    found = kinematics_of(ARPH).forward(postures, np.zeros((len(postures), 3))).tip[:, 2]
    return float(found.min()), float(found.max())


def largest_turn(way: Array, direction: Array) -> float:
    """Return the largest angle [rad] between a direction (3) and chords of a way (K, 3) [m].

    From each point the chord leads to the first one that is `CHORD` away, if there is one: a hand
    that stands has no direction.
    """
    largest = 0.0
    for i, here in enumerate(way):
        chords = way[i + 1 :] - here
        lengths = np.linalg.norm(chords, axis=1)
        far = np.nonzero(lengths >= CHORD)[0]
        if far.size:
            cosine = chords[far[0]] @ direction / lengths[far[0]]
            largest = max(largest, float(np.arccos(np.clip(cosine, -1.0, 1.0))))
    return largest
