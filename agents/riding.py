"""How a platform drives for a hand that rides on it: an arm of which but one joint moves."""

from agents.agent import Array, Joints
from agents.arithmetic import (
    anywhere,
    arcsin,
    arctan2,
    cos,
    exp,
    greater,
    lesser,
    mixed,
    ramp,
    sin,
    where,
    within,
)
from agents.lifting import Lift, Lifting, Place
from agents.pursuit import Pursuit
from agents.scene import Scene
from agents.sight import View
from plant.robot import Drive


class Riding:
    """Brings a hand over the goal that the arm can only lift.

    Such a hand is a point of the platform. One joint has the height in its care, and as it lifts
    the hand it shifts it over the platform, on a circle that can be told beforehand. The platform
    answers for the rest, and does so for where the hand will be once its height is right: what
    the arm still misses in height is none of its business, so the two do not answer each other.

    A hand ahead of the axle it leads: where the hand is to go gives speed and turning at once
    (the point ahead of the axle of d'Andrea-Novel, Campion and Bastin 1995). A hand beside or
    behind it would turn such a platform round; so that one is carted: the axle is brought to its
    own place, as in `Towing`, yet not facing where the goal goes, but a little off, by as much as
    makes up for the hand's drift sideways. That has to begin ahead of time: the hand swings out
    when the platform turns. How far off is worked out from the drift to come, weighed by
    how soon it comes: the bounded solution of the platform's own inverse (Devasia, Chen and
    Paden 1996).

    To the person beside the robot this is an arm as good as broken that still holds the cup
    level with their mouth.
    """

    BESIDE = 0.25, 0.4188  # [m] of the hand ahead of the axle: ridden up to there, served beyond
    ALONE = 0.98, 0.996  # share of the hand's motion that is one joint's: not ridden, ridden
    GLANCES = 0.01  # [s] that pass between two looks at the joints while no hand rides
    BRISK = 3.074  # [rad/s2] with which turning changes
    LEADS = 0.03825, 0.1474  # [m] of the hand ahead of the axle: carted up to there, led from there
    KEEN = 2.047  # [1/s] of what a led hand misses
    LOOKS = 0.04  # [m] along the line that the axle keeps to, at the least
    SOON = 0.623  # [s] of driving that it looks ahead, at the least
    TURNS = 2.5  # [rad/s] for each radian off that way
    AGREES = 9.3  # [1/s] at which it takes on the goal's speed
    CATCHES_UP = 19.26  # [1/s2] for each metre that it is behind its place
    OFF = 0.8  # sine of the most that it heads off where the goal goes
    LEVERS = 8.0  # distances of hand and axle that the goal goes on by in the time foreseen
    LONGEST = 60.0  # [s] that are foreseen at the most
    STEPS = 16  # in which it is foreseen
    PASSES = 2  # over each step: its middle is known only once its beginning is
    LEAST = 0.02  # [m] of hand and axle, so that nothing is infinite
    SWINGS = 1.0  # [rad/s] with which the heading wanted may change

    def __init__(self, drive: Drive) -> None:
        """Drive as fast as that drive may."""
        self._drive = drive
        self._pursuit = Pursuit(
            drive.max_linear, turns=self.TURNS, agrees=self.AGREES, catches_up=self.CATCHES_UP
        )
        self._lifting: Lifting | None = None
        self._unseen = 0.0  # [s] since it last looked which joints move
        self._rides = False

    def instead_of(
        self, speeds: tuple[Array, Array], elapsed: float, scene: Scene, view: View, joints: Joints
    ) -> tuple[Array, Array]:
        """Return linear (...) [m/s] and angular (...) [rad/s], `elapsed` [s] after the last.

        speeds: what they are as far as the hand does not ride
        """
        ridden = scene.led_on * (1 - ramp(scene.carried, *self.BESIDE))
        self._unseen += elapsed
        if not anywhere(ridden):
            self._lifting, self._rides = None, False
            return speeds
        if self._unseen < self.GLANCES and not self._rides:
            return speeds
        if self._lifting is None:
            self._lifting, self._unseen = Lifting(), elapsed
        lift = self._lifting.watch(self._unseen, view, joints, scene)
        ridden = ridden * ramp(lift.alone, *self.ALONE) * view.modelled
        self._rides, self._unseen = anywhere(ridden), 0.0
        if not self._rides:  # as while several joints move; the rest takes long to work out
            return speeds
        linear, angular = self._speeds(elapsed, scene, lift)
        angular = scene.angular + within(angular - scene.angular, self.BRISK * elapsed)
        return greater(mixed(speeds[0], linear, ridden), 0.0), mixed(speeds[1], angular, ridden)

    def _speeds(self, elapsed: float, scene: Scene, lift: Lift) -> tuple[Array, Array]:
        place = lift.at(scene.hand[2] + scene.missing[2])
        carted, led = self._carted(elapsed, scene, lift, place), self._led(scene, place)
        ahead = ramp(place.ahead, *self.LEADS)
        return mixed(carted[0], led[0], ahead), mixed(carted[1], led[1], ahead)

    def _led(self, scene: Scene, place: Place) -> tuple[Array, Array]:
        """Return the speeds at which the hand itself goes to the goal and with it."""
        ahead, left = place.ahead, place.left
        ahead_x, ahead_y = scene.ahead
        missing_x, missing_y, _ = scene.missing
        going_x, going_y, rises = scene.going
        missing_ahead = missing_x * ahead_x + missing_y * ahead_y + scene.carried - ahead
        missing_left = missing_y * ahead_x - missing_x * ahead_y + scene.aside - left
        to_ahead = going_x * ahead_x + going_y * ahead_y - place.ahead_slope * rises
        to_left = going_y * ahead_x - going_x * ahead_y - place.left_slope * rises
        to_ahead, to_left = to_ahead + self.KEEN * missing_ahead, to_left + self.KEEN * missing_left
        angular = to_left / greater(ahead, self.LEADS[0])
        linear = to_ahead + angular * left
        # what would take driving backwards is left to turning, as far as that serves
        turning = (ahead * to_left - left * to_ahead) / greater(ahead * ahead + left * left, 0.01)
        angular = where(linear < 0, turning, angular)
        linear = greater(linear, 0.0)
        too_fast = greater(linear / self._drive.max_linear, abs(angular) / self._drive.max_angular)
        slower = greater(too_fast, 1.0)
        return linear / slower, angular / slower

    def _carted(
        self, elapsed: float, scene: Scene, lift: Lift, place: Place
    ) -> tuple[Array, Array]:
        """Return the speeds at which the axle comes to its place and keeps it."""
        speed = greater(scene.speed, 1e-6)
        off, swings = self._off(scene, lift, place)
        sine, cosine = sin(off), cos(off)
        on_x = (scene.going[0] * cosine + scene.going[1] * sine) / speed
        on_y = (scene.going[1] * cosine - scene.going[0] * sine) / speed
        along, beside = Pursuit.place(scene, (on_x, on_y), place.ahead, place.left)
        looks = greater(self.SOON * scene.linear, self.LOOKS)
        course = arctan2(on_y, on_x) + arctan2(beside, looks) - swings / self.TURNS
        drifts = place.ahead_slope * scene.going[2] + place.left * swings
        slower = scene.speed * cosine - drifts - scene.linear
        return self._pursuit.speeds(elapsed, scene, along, slower, course)

    def _off(self, scene: Scene, lift: Lift, place: Place) -> tuple[Array, Array]:
        """Return how far (...) [rad] to head to the right of where the goal goes, and its rate.

        With d that angle, V the goal's speed, a how far ahead of the axle the hand is and b' how
        fast it drifts to the left, the hand keeps beside the goal if a d' = b' - V sin d. Behind
        the axle (a < 0) this is stable backwards in time, so it is solved from the future on;
        ahead of it from the past.
        """
        speed = greater(scene.speed, 1e-6)
        height, rises = scene.hand[2] + scene.missing[2], scene.going[2]
        sign = where(place.ahead > 0, -1.0, 1.0)
        lever = greater(abs(place.ahead), self.LEAST)
        foreseen = lesser(self.LEVERS * lever / speed, self.LONGEST)
        step = lesser(foreseen, lift.time_left(height, rises * sign)) / self.STEPS

        def steady(k: int) -> tuple[Array, Array]:
            then = lift.at(height + rises * step * (sign * k))
            sine = within(then.left_slope * rises / speed, self.OFF)
            return greater(abs(then.ahead), self.LEAST), arcsin(sine)

        later_lever, later = steady(self.STEPS)
        off = later
        for k in range(self.STEPS - 1, -1, -1):
            now_lever, now = steady(k)
            levers = 2 * step * speed / (now_lever + later_lever)
            before = off
            for _ in range(self.PASSES):
                # sin d - sin d' is cos((d + d') / 2) times d - d', nearly
                turns = greater(levers * cos(0.25 * (now + later + before + off)), 1e-6)
                kept = exp(-turns)
                # exact for a steady angle that changes evenly from one step to the next
                came = (later - now) * (1 - kept * (1 + turns)) / turns
                before = now * (1 - kept) + came + kept * off
            off = before
            later_lever, later = now_lever, now
        swings = sign * (speed * sin(off) - place.left_slope * rises) / lever
        return off, within(swings, self.SWINGS)
