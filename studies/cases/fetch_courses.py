"""Courses on which a cup is fetched: where things and the person are, and the faults, drawn."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from math import atan2

import numpy as np

from agents.agent import Array
from runtime.config.chaos import MANNERS, ChaosEvent, fault
from runtime.config.overrides import Override

TOP = 0.70
"""Height of the table's top [m]."""
ABOVE = 0.06
"""How high above the table's top the cup is taken [m]: a little above its middle."""
BEFORE = 0.1
"""How far before the cup, as the robot comes, the hand opens [m]."""
ASIDE = 0.4
"""How far to the side of the person the cup is carried before it goes there [m]: a hand that came
back over the platform at once would need it away, and it only drives forward, under the table."""
LOCKED = (1, 4, 6)
"""The joints of which one is locked after the grasp."""


@dataclass(frozen=True)
class Course:
    """Where everything is, in the world.

    Attributes:
        start: (3,) x, y [m] and heading [rad] of the platform.
        round: (2,) x, y where the hand is led round the box [m].
        cup: (2,) x, y [m].
        table: (2,) x, y of its middle [m].
        jug: (2,) x, y [m].
        bowl: (2,) x, y [m].
        box: (2,) x, y of a box on the floor, in the straight way to the cup [m].
        mouth: (3,) of the person [m].
        away: (2,) unit vector in which the person is away from the mouth.
    """

    start: Array
    round: Array
    cup: Array
    table: Array
    jug: Array
    bowl: Array
    box: Array
    mouth: Array
    away: Array

    def overrides(self) -> tuple[Override, ...]:
        """Return what it changes in deploy/fetch.yaml."""
        values = {
            "start.platform": self.start.tolist(),
            "world": self._world(),
            "goal.steps": self._steps(),
        }
        return tuple(Override("the course", key, json.dumps(v)) for key, v in values.items())

    def _world(self) -> list[dict[str, object]]:
        person = self.mouth[:2] + 0.25 * self.away
        yaw = atan2(self.away[1], self.away[0])
        leg = self.table + (self.table - self.cup)  # at the far rim, as of a table over a bed
        return [
            _object("table", self.table, TOP - 0.015, cylinder=[0.35, 0.03], fixed=True),
            _object("table leg", leg, 0.335, cylinder=[0.04, 0.67], fixed=True),
            _object("cup", self.cup, TOP + 0.05, cylinder=[0.03, 0.1], mass=0.3),
            _object("jug", self.jug, TOP + 0.125, cylinder=[0.05, 0.25], mass=1.0),
            _object("bowl", self.bowl, TOP + 0.03, box=[0.14, 0.14, 0.06], mass=0.4),
            _object("box", self.box, 0.2, box=[0.4, 0.3, 0.4], fixed=True),
            _object("chair", person + 0.2 * self.away, 0.225, box=[0.45] * 3, yaw=yaw, fixed=True),
            _object("person", person, 0.825, cylinder=[0.15, 0.75], fixed=True),
        ]

    def _steps(self) -> list[dict[str, object]]:
        height, cup = TOP + ABOVE, self.cup.tolist()
        before = self.cup * (1.0 - BEFORE / np.linalg.norm(self.cup))
        ahead_x, ahead_y = self.cup / np.linalg.norm(self.cup)
        left = np.array([-ahead_y, ahead_x])
        aside = self.cup + ASIDE * np.sign(left @ self.away) * left
        empty = [[*self.round.tolist(), height], [*before.tolist(), height], [*cup, height]]
        holds = [[*cup, height], [*cup, TOP + 0.25], [*aside.tolist(), TOP + 0.3]]
        level = {"rpy": [0.0, 0.0, 0.0], "free": "roll"}
        steps = [{"position": place, **level, "grip": 0.1} for place in empty]
        steps[0]["tolerance"] = 0.05
        return steps + [
            {"position": place, **level, "grip": 0.0, "holds": True}
            for place in [*holds, self.mouth.tolist()]
        ]


def _object(name: str, place: Array, height: float, **more: object) -> dict[str, object]:
    return {"name": name, "position": [*place.tolist(), height], **more}


def _towards(angle: float) -> Array:
    return np.array([np.cos(angle), np.sin(angle)])


def course(seed: int, number: int) -> Course:
    """Draw a course: a box is in the straight way to the cup, and the hand is led round it.

    From there the cup is about in front of the robot. The person is to its left or right, so that
    it has to turn, and the box and the middle of the table on the other side. Nobody looks where
    the platform goes: it drives forward only, and past a table in its way its column would not
    come.
    """
    rng = np.random.default_rng([seed, number, 0xF7])
    bearing, side = rng.uniform(-0.3, 0.3), rng.choice([-1.0, 1.0])
    cup = rng.uniform(1.1, 1.5) * _towards(bearing)
    behind = bearing - side * rng.uniform(0.1, 0.6)  # the table's middle
    table = cup + 0.27 * _towards(behind)
    others = behind + np.pi + rng.choice([-1.0, 1.0]) * np.radians(rng.uniform(100.0, 150.0, 2))
    away = _towards(bearing + side * np.radians(rng.uniform(90.0, 130.0)))
    mouth = np.append(cup + rng.uniform(1.2, 1.7) * away, rng.uniform(1.0, 1.2))
    ahead, across = _towards(bearing), side * _towards(bearing + 0.5 * np.pi)
    start = -rng.uniform(0.65, 0.75) * ahead - rng.uniform(0.6, 0.65) * across
    led = 0.3 * ahead + 0.45 * across
    return Course(
        start=np.append(start, atan2(*(led - start)[::-1])),
        round=led,
        cup=cup,
        table=table,
        jug=table + 0.22 * _towards(others[0]),
        bowl=table + 0.22 * _towards(2.0 * (behind + np.pi) - others[1]),
        box=rng.uniform(0.1, 0.2) * ahead - rng.uniform(0.68, 0.72) * across,
        mouth=mouth,
        away=away,
    )


def one_fault(
    seed: int, number: int, roles: Sequence[str], taken: float, delivered: float
) -> tuple[ChaosEvent, ...]:
    """Draw a fault of a course: of a process while it runs, or of a joint that holds the cup.

    Args:
        seed: As of `course`.
        number: As of `course`.
        roles: Those of all processes that may be hit.
        taken: When the cup is held without a fault [s].
        delivered: When it is at the mouth without a fault [s].

    Returns:
        The events: with equal chances a process is killed for good, hangs, or is killed and started
        again, or a joint locks.
    """
    rng = np.random.default_rng([seed, number, 0xFA])
    manner = str(rng.choice([*MANNERS, "lock"]))
    if manner == "lock":
        at, joint = rng.uniform(taken, delivered), int(rng.choice(LOCKED))
        return (ChaosEvent(at=round(at, 2), fault=f"joint/{joint}:locked"),)
    role, at, lasting = rng.choice(roles), rng.uniform(0.0, delivered), rng.uniform(0.5, 3.0)
    return fault(str(role), manner, round(float(at), 2), round(float(lasting), 2))
