"""A person who holds one button of the page after the other, with the robot in lockstep."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from agents.agent import Array
from agents.attitude import turn_between
from nodes.hmi.jogging import joint_index, level_axes
from plant.faults import Fault
from plant.kinematics import kinematics_of
from plant.robot import numbers
from studies.driven_robot import DrivenRobot
from studies.mobile import ARPH, PERIOD

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


class Driven:
    """A robot with which a person draws a square in shared mode, while parts of it fail.

    Args:
        square: What is drawn.
        faults: In their text form, and roles of agents to kill.
        seed: Of all random numbers.
    """

    def __init__(self, square: Square, faults: Sequence[str], seed: int) -> None:
        base = np.array([0.0, 0.0, square.heading])
        self._robot = DrivenRobot(square.q, base, "shared", square.speed, seed)
        self._square, self._faults, self._held = square, list(faults), 0.0
        broken = [joint_index(fault.partition(":")[0], ARPH.n) for fault in faults]
        self._broken = [joint for joint in broken if joint is not None]

    def side(self, button: str) -> Side:
        """Hold a button until the hand has gone the side, or stands; then let it come to rest."""
        square, robot, start = self._square, self._robot, self._robot.hand
        direction = np.array(SIDES[button]) @ level_axes(square.camera)
        looks = round(STANDS / PERIOD)
        hands, along = [start], [0.0]
        robot.hold("hand", (*SIDES[button], 0.0, 0.0, 0.0), square.camera)
        while along[-1] < square.side and len(hands) * PERIOD < HOLDS:
            if len(along) > looks and along[-1] - along[-1 - looks] < BARELY:
                break
            self._break()
            robot.go_on(PERIOD)
            hands.append(robot.hand)
            along.append(float((hands[-1].position - start.position) @ direction))
        took = (len(hands) - 1) * PERIOD
        robot.let_go()
        for _ in range(round(RESTS / PERIOD)):
            robot.go_on(PERIOD)
            hands.append(robot.hand)
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
        low, high = heights(numbers(self._robot.plant.read().q), self._broken)
        return low <= height <= high

    def _break(self) -> None:
        self._held += PERIOD
        if self._held > self._square.breaks:
            while self._faults:
                fault = self._faults.pop()
                if self._robot.agents.pop(fault, None) is None:
                    self._robot.plant.inject(Fault.parse(fault, ARPH))


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
