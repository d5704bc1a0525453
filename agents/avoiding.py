"""How a platform's agent takes care of what is around it: it sees, limits its speed, says why."""

import numpy as np

from agents.agent import Array, Places
from agents.braking import Brakes
from agents.clearance import MARGIN
from agents.echoes import Echoes, Sonar
from agents.outline import Outline
from agents.steering import SMALL
from plant.belt import Ranges
from plant.robot import Robot

NEAR = 0.5
"""[L] Echoes that are nearer count with the whole arc on which they may lie; farther away only its
middle does. Chosen: the arcs of far ones would close every gap."""
STANDS = 0.1
"""[L] Way that is none: within it, the platform stands, whether or not it turns and looks for a
way. Chosen: a seventh of ARPH's own length."""
WAITS = 2.0
"""[L / v_max] How long it stands before it says so. Chosen: 7 s with ARPH, longer than it takes to
turn to another way."""


class Avoiding:
    """What one platform knows of what is around it, and what follows for its speeds.

    Attributes:
        outline: Of the platform.
        shares: (2,) of the planned speeds that it may have.
    """

    def __init__(self, robot: Robot, reach: float, plans: float, period: float) -> None:
        """Look after a robot that has a drive and a belt.

        Args:
            robot: Its description.
            reach: L [m].
            plans: From one plan to the next [L / v_max].
            period: Of the control loop [s].
        """
        drive, belt = robot.drive, robot.belt
        assert drive is not None
        assert belt is not None
        self._reach, self._unit = reach, reach / drive.max_linear
        self.outline = Outline(robot)
        self._turns = self.outline.radius + MARGIN * reach
        self._sonar = Sonar(belt, self.outline, reach, self._unit)
        late = plans * self._unit + 2 * period  # a plan is as old, and so is what it went by
        self._brakes = Brakes(drive, self.outline, self._sonar, reach, late)
        self.forget()

    def forget(self) -> None:
        """Begin anew, knowing nothing."""
        self.shares = np.zeros(2)
        self._echoes: Echoes | None = None
        self._stood: tuple[float, complex] | None = None  # since when [s], and where
        self._hears = False

    def seen(self, t: float, base: Array, ranges: Ranges | None) -> Places | None:
        """Look, and return what is to be kept clear of, as the platform faces [m]; None if nothing.

        Args:
            t: Plant time [s].
            base: (3,) x, y [m] and heading [rad].
            ranges: What the belt measures; None if nothing is heard of it.
        """
        self._hears = ranges is not None
        measured = None if ranges is None else np.array(ranges.ranges)
        self._echoes = echoes = self._sonar.look(self._echoes, t, base, measured)
        near = np.where(echoes.ranges < NEAR * self._reach, echoes.ranges, np.inf)
        arcs = self._sonar.arcs(near).ravel()
        place, turn = complex(base[0], base[1]), np.exp(-1j * base[2])
        points, unseen = ((some - place) * turn for some in (echoes.points, echoes.unseen))
        unseen *= np.maximum(1.0, self._turns / np.abs(unseen))  # it may always turn to look
        near_by: Places = np.concatenate([arcs[np.isfinite(arcs)], unseen, points])
        return near_by if near_by.size else None

    def limited(self, base: Array, planned: Array, off: Array) -> str:
        """Limit the speeds planned, and return why the platform stands; nothing if it need not.

        Args:
            base: As of `seen`.
            planned: (2,) [m/s], [rad/s].
            off: Distance of the hand from its goal on the level [m].
        """
        echoes = self._echoes
        assert echoes is not None
        limit = self._brakes.limit(echoes, base, planned)
        self.shares = limit.shares
        goes = self._stood is None or abs(echoes.place - self._stood[1]) > STANDS * self._reach
        if self._stood is None or goes or off < 2 * SMALL * self._reach:
            self._stood = echoes.t, echoes.place
        if echoes.t - self._stood[0] < WAITS * self._unit:
            return ""
        if not self._hears:
            return "stands: hears nothing of its range sensors"
        if np.isnan(echoes.ranges).all():
            return "stands: all its range sensors are lost"
        if echoes.t < echoes.waits:
            return "stands: something moves around it"
        if limit.nearest is None or limit.gap > self._reach:
            return ""
        where = np.angle(limit.nearest)
        side = int(np.round(2 * where / np.pi)) % 4
        name = ("ahead", "to its left", "behind", "to its right")[side]
        return f"stands: something {max(limit.gap, 0.0):.2f} m away {name}, and sees no way round"
