"""Line minimisation in which all joints take an even part."""

from math import exp

from agents.adaptation import EagerGain
from agents.agent import Array, Body
from agents.arithmetic import between, greater, lesser, moved, sqrt, squared_length, within
from agents.laws import LineByModel
from plant.kinematics import Parts


class Insistence:
    """Asks for more of what stays missing.

    An error that every joint can mend is gone at once, or has changed its sign. One that no joint
    can do much about by itself, as when the hand is straight ahead of the arm but too near, stays,
    and each joint's own best turn is next to nothing though all together could do it. So what was
    missing of late is added to what is missing now, half as much again at most: with as much again,
    some arms with two joints locked swung to and fro for ever.
    """

    SHARE = 0.5
    TINY = 1e-20  # [m2] so that nothing missing divides by something

    def __init__(self, memory: float) -> None:
        """Remember for about `memory` [s]."""
        self._memory = memory
        self._lasting: Parts | None = None

    def after(self, missing: Parts, elapsed: float) -> Parts:
        """Return what to ask for on top of `missing` [m]: [m].

        elapsed: time since the last time [s]
        """
        if self._lasting is None:
            self._lasting = missing
        else:
            forgotten = 1 - exp(-elapsed / self._memory)
            self._lasting = moved(self._lasting, between(self._lasting, missing), forgotten)
        now, lasting = squared_length(missing), squared_length(self._lasting)
        share = self.SHARE * sqrt(now / greater(greater(lasting, now), self.TINY))
        x, y, z = self._lasting
        return share * x, share * y, share * z


class BolderGain(EagerGain):
    """A gain for those who never have the whole of an error to themselves."""

    GROWTH = 1.85
    CUT = 0.6
    OVERSHOT = 0.4


class EvenLineByModel(LineByModel):
    """Line minimisation in which no joint is left behind.

    What stays missing is asked for more (`Insistence`), and all turn slowly when the hand is near
    its goal: those that have much to do would else go on at full speed while the others wait for
    them. So all have a part in the motion till its end, as in a person's arm. On a mobile arm,
    where the platform makes up for what stays missing, the plain law does better.
    """

    GAIN = BolderGain
    INSISTENCE = 1.5  # horizons for which what stays missing is remembered
    NEAR = 0.2  # [m] from the goal where it begins to turn more slowly
    LEAD = 1.0  # [s] of a moving goal's way that counts as distance there
    LEAST = 0.2  # share of its top speed that it may always use, to make up for what others do

    def __init__(
        self, body: Body, joint: int, *, gain: float, horizon: float, memory: float, bend: float
    ) -> None:
        """Turn joint `joint` (from 0) of that body: see `JointAgent` for the rest."""
        super().__init__(body, joint, gain=gain, horizon=horizon, memory=memory, bend=bend)
        self._insistence = Insistence(self.INSISTENCE * horizon)

    def aim(self, place: Parts, ahead: Parts, elapsed: float) -> Parts:
        """Return where to bring the hand: beyond `place` by what stays missing [m]."""
        return moved(place, self._insistence.after(between(ahead, place), elapsed), 1.0)

    def paced(self, velocity: Array, hand: Parts, place: Parts, going: Parts) -> Array:
        """Return the velocity (...) [rad/s], bounded near the goal."""
        far = sqrt(squared_length(between(hand, place))) + self.LEAD * sqrt(squared_length(going))
        most = self._top_speed * greater(sqrt(lesser(far / self.NEAR, 1.0)), self.LEAST)
        return within(velocity, most)
