"""What touches what in a MuJoCo model, and with which force."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

_APART = 0.2  # [s] without a touch after which a contact is over: what rattles is one contact


class Touch(NamedTuple):
    """A contact that is over.

    Attributes:
        body: Name of a body; the robot's, if one is.
        other: Name of what it has touched.
        of_robot: Whether the first is part of the robot.
        began: Time of the first touch [s].
        ended: Time of the last touch [s].
        force: Largest normal force [N].
        mean: Mean normal force from the first touch to the last [N].
    """

    body: str
    other: str
    of_robot: bool
    began: float
    ended: float
    force: float
    mean: float


@dataclass
class _Open:
    """A contact that goes on; `impulse` is its force summed over time [N s]."""

    began: float
    last: float
    force: float = 0.0
    impulse: float = 0.0


class ContactForces:
    """The contacts of a run by pairs of bodies, with the normal forces that MuJoCo computes."""

    def __init__(
        self,
        model: Any,
        data: Any,
        bodies: Sequence[str],
        robot: frozenset[int],
        rolling: Sequence[str],
    ) -> None:
        """Look at the contacts of a model.

        Args:
            model: Compiled, with elliptic friction cones.
            data: Its state.
            bodies: What each body is called.
            robot: The numbers of the robot's bodies.
            rolling: Names of the geoms on which the robot stands, which is no contact.
        """
        self._data, self._bodies, self._robot = data, bodies, robot
        self._body: list[int] = model.geom_bodyid.tolist()  # by geom; -1 where it is no contact
        for name in rolling:
            self._body[model.geom(name).id] = -1
        self._step = model.opt.timestep
        self._open: dict[tuple[int, int], _Open] = {}
        self._over: list[Touch] = []

    def add(self, t: float) -> None:
        """Take the forces of the time step that has led to time `t` [s]."""
        data, body = self._data, self._body
        if not data.ncon:
            return
        contact, felt = data.contact, data.efc_force.tolist()
        forces: dict[tuple[int, int], float] = {}
        # lists, as they are short; the first row of a contact is its normal force
        for (a, b), row in zip(contact.geom.tolist(), contact.efc_address.tolist(), strict=True):
            one, other = body[a], body[b]
            if min(one, other, row) >= 0:  # one within its margin has no row
                pair = (one, other) if one < other else (other, one)
                forces[pair] = forces.get(pair, 0.0) + felt[row]
        for pair, force in forces.items():
            touch = self._open.get(pair)
            if touch is None:
                touch = self._open[pair] = _Open(t - self._step, t)
            touch.last = t
            touch.force = max(touch.force, force)
            touch.impulse += force * self._step

    def touched(self, body: int, since: float) -> frozenset[int]:
        """Return the numbers of the bodies that a body has touched since that time [s]."""
        pairs = (pair for pair, touch in self._open.items() if touch.last >= since)
        return frozenset(sum(pair) - body for pair in pairs if body in pair)

    def over(self, t: float) -> list[Touch]:
        """Return the contacts that are over at time `t` [s] and were not when last asked."""
        for pair, touch in list(self._open.items()):
            if t - touch.last > _APART:
                self._close(pair)
        over, self._over = self._over, []
        return over

    def close(self) -> None:
        """Let all contacts be over."""
        for pair in list(self._open):
            self._close(pair)

    def _close(self, pair: tuple[int, int]) -> None:
        touch = self._open.pop(pair)
        # the robot's body first: a higher number than the floor's, and lower than an object's
        one, other = sorted(pair, key=lambda body: (body not in self._robot, body))
        names = self._bodies[one], self._bodies[other]
        mean = touch.impulse / (touch.last - touch.began)
        robot = one in self._robot
        self._over.append(Touch(*names, robot, touch.began, touch.last, touch.force, mean))
