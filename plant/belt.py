"""A belt of ultrasonic range sensors around the front of a platform (paper, section 2)."""

import math
from dataclasses import dataclass
from typing import Annotated, NamedTuple

from plant.errors import MsmaError

Length = Annotated[float, "m"]
Angle = Annotated[float, "rad"]


class BeltError(MsmaError, ValueError):
    """A belt that there cannot be; the message begins with the attribute that is wrong."""


class Ranges(NamedTuple):
    """What a belt measures.

    Attributes:
        ranges: Distance of the nearest echo in each sensor's cone [m], from the leftmost sensor to
            the rightmost; the largest range where there is none, NaN where a sensor is lost.
    """

    ranges: tuple[float, ...]


class RangeSensor(NamedTuple):
    """Where one sensor is on the platform.

    Attributes:
        x: Forward of the base's frame [m].
        y: To the left of it [m].
        bearing: Direction of the middle of its cone [rad], 0 = forward, positive to the left.
    """

    x: float
    y: float
    bearing: float


@dataclass(frozen=True, kw_only=True)
class Belt:
    """Sensors on an arc at the front of a platform, each looking outward.

    Attributes:
        sensors: How many.
        spread: Angle between the directions of the first and the last one [rad].
        height: Above the floor [m].
        radius: Of the arc [m].
        centre: Of the arc, in front of the base's frame [m].
        cone: Full angle of each cone [rad].
        rays: How many rays stand for a cone.
        least: The smallest range: what is nearer is measured as this [m].
        most: The largest range: what is farther away is not seen [m].
        noise: Standard deviation of a measurement [m].
        rate: How often all sensors measure [Hz]; by default each control period. In between, the
            last measurement is published again.
        dropouts: Share of measurements without an echo where there should be one.
        mirror: Largest angle between a ray and the normal of a surface that sends an echo back
            [rad]; smooth walls at flatter angles are mirrors that are not seen.
    """

    sensors: int
    spread: Angle = math.pi
    height: Length = 0.3
    radius: Length = 0.2
    centre: Length = 0.25
    cone: Angle = math.pi / 6
    rays: int = 13
    least: Length = 0.05
    most: Length = 3.0
    noise: Length = 0.01
    rate: Annotated[float, "Hz"] | None = None
    dropouts: float = 0.0
    mirror: Angle = math.pi / 2

    def __post_init__(self) -> None:
        """Raise `BeltError` for what cannot be."""
        bounds: dict[str, tuple[float, float, str]] = {
            "sensors": (1, 64, "from 1 to 64"),
            "spread": (0.0, math.tau, "from 0 to 360 deg"),
            "height": (0.0, math.inf, "not negative"),
            "radius": (0.0, math.inf, "not negative"),
            "cone": (0.0, math.pi, "from 0 to 180 deg"),
            "rays": (1, 1000, "from 1 to 1000"),
            "least": (0.0, self.most, "from 0 to the largest range, `most`"),
            "noise": (0.0, math.inf, "not negative"),
            "dropouts": (0.0, 1.0, "a share from 0 to 1"),
            "mirror": (0.0, math.pi / 2, "from 0 to 90 deg"),
        }
        for name, (low, high, wanted) in bounds.items():
            if not low <= getattr(self, name) <= high:
                raise BeltError(f"{name}: {getattr(self, name):g} must be {wanted}")
        if self.rate is not None and not self.rate > 0.0:
            raise BeltError(f"rate: {self.rate:g} Hz must be positive")

    @property
    def layout(self) -> tuple[RangeSensor, ...]:
        """Where each sensor is, from the leftmost to the rightmost."""
        between = self.spread / (self.sensors - 1) if self.sensors > 1 else 0.0
        first = 0.5 * self.spread if self.sensors > 1 else 0.0
        bearings = [first - number * between for number in range(self.sensors)]
        return tuple(
            RangeSensor(self.centre + self.radius * math.cos(a), self.radius * math.sin(a), a)
            for a in bearings
        )
