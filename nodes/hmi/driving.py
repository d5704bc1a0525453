"""Driving: what viewers press becomes jogs and goals, and ends when it has to.

It is told of everything with the time at which that happened, and has no clock of its own.
"""

from collections.abc import Callable, Sequence
from typing import Protocol

from msgspec import Struct

from nodes.hmi.drivers import Change, Drivers
from nodes.hmi.gripping import WantedGrip, fits_gripper, grip_speed
from nodes.hmi.jogging import (
    GoalPiece,
    Motion,
    PartSpeeds,
    Place,
    axes_of,
    fits_hand,
    grip_axes,
    hand_motion,
    is_at,
    motion_to,
    part_speeds,
    step_done,
    target_pose,
    way_between,
)
from nodes.hmi.leading import LedGoal
from nodes.hmi.presses import End, Pictures, Press, Presses, Situation
from nodes.hmi.protocol.incoming import Jog
from nodes.hmi.protocol.outgoing import Ended, Said
from nodes.hmi.protocol.values import Limits, Pose, Times
from nodes.hmi.seen import Seen, pose_of
from nodes.hmi.stops import at_stops
from plant.robot import Robot

_KEPT = 256  # states whose age is known: 10 s at 25 a second
_SETTLES = 0.6  # [s] for which a hand may move on after a press, and its goal with it
_OBEYED = 0.3  # [s] after which the plant has said that it obeys a press, if it does

Post = Callable[[int | None, Struct], None]
"""Sends a message to a viewer, or to all for None."""


class Link(Protocol):
    """What is published for the robot; see `RobotLink`."""

    incarnation: int

    def jog(self, press: Press, t: float, speeds: PartSpeeds, motion: Motion = ...) -> None:
        """Publish that a press is held, in answer to a state of plant time `t` [s]."""

    def release(self, press: Press, t: float) -> None:
        """Publish that a press is over."""

    def lead(self, piece: GoalPiece, t: float) -> None:
        """Publish a goal that moves."""

    def stand(self, pose: Pose, t: float) -> None:
        """Publish a goal that stands."""


class Driving:
    """Who presses what, and what that makes of the robot.

    In shared mode the gripper's agent opens and closes it, if there `has_gripper_agent`.

    Attributes:
        seen: The robot, as of the last look.
        drivers: Who drives.
        pictures: The states that were sent.
        marker: The goal that somebody has set in automatic mode, published on and on.
    """

    def __init__(
        self,
        robot: Robot,
        limits: Limits,
        times: Times,
        link: Link,
        post: Post,
        seen: Seen,
        has_gripper_agent: bool,
    ) -> None:
        self.seen = seen
        self.drivers = Drivers(times.idle)
        self.pictures = Pictures(_KEPT)
        self.marker: Pose | None = None
        self._robot, self._limits, self._times = robot, limits, times
        self._link, self._post = link, post
        self._presses = Presses(self.drivers, times)
        self._grip = grip_axes(robot)
        self._has_gripper_agent = has_gripper_agent
        self._led: LedGoal | None = None
        self._caution = 0.0  # of the presses before: see `LedGoal`
        self._wanted_grip: WantedGrip | None = None
        self._start: Place = seen.place
        self._explained = False  # that this press does not get on
        self._settles_until = 0.0

    def press_of(self, viewer: int) -> int:
        """Return the number of the viewer's press that moves the robot; 0 if none does."""
        alive = self._presses.alive
        return alive.number if alive is not None and alive.viewer == viewer else 0

    def look(self, seen: Seen, now: float) -> None:
        """Take what is seen of the robot `now` [s], and end what that or the time ends."""
        self.seen = seen
        ends = self._presses.expire(now)
        press, operator = self._presses.alive, seen.operator
        if press is not None:
            if operator is None:
                ends += self._presses.end("plant")
            elif operator.halted:
                ends += self._presses.end("halted")
            elif operator.mode != press.jog.mode:
                ends += self._presses.end("mode")
            elif now - press.began > _OBEYED and not self._is_obeyed(press):
                self._post(press.viewer, Said("refused.robot", {"why": operator.why}, urgent=True))
                ends += self._presses.end("plant")
        self._end(press, ends, now)
        self.announce(self.drivers.look(now))
        if operator is not None and operator.halted:
            self.announce(self.drivers.revoke())
        if operator is None or operator.mode != "automatic" or operator.halted:
            self.marker = None
        if self.marker is not None:
            self._link.stand(self.marker, seen.t)
        elif now < self._settles_until and seen.hand is not None and self._led is None:
            self._link.stand(pose_of(seen.hand), seen.t)

    def _is_obeyed(self, press: Press) -> bool:
        operator = self.seen.operator
        own = self._link.incarnation, press.serial
        return operator is not None and (operator.driver, operator.press) == own

    def jog(self, viewer: int, jog: Jog, now: float) -> None:
        """Take a jog that arrived `now` [s]."""
        before = self._presses.alive
        speeds = part_speeds(jog, self._robot) if jog.mode == "manual" else PartSpeeds()
        can_grip = fits_gripper(jog, self._robot, self._has_gripper_agent)
        picture = self.pictures.of(jog.state)
        operator = self.seen.operator
        ends = self._presses.jog(
            viewer,
            jog,
            Situation(
                None if operator is None or self._is_lost(jog) else operator.mode,
                operator is not None and operator.halted,
                None if picture is None else now - picture.sent,
                fits=speeds is not None and fits_hand(jog) and can_grip,
            ),
            now,
        )
        self._end(before, ends, now)
        press = self._presses.alive
        if press is None or press.jog is not jog or speeds is None or picture is None:
            return
        if press is not before:
            self._begin(press, now)
        gripper = self._robot.gripper
        if jog.grip and self._wanted_grip is None and gripper is not None:
            lease = self._times.lease
            self._wanted_grip = WantedGrip(gripper, self.seen.gripper, now, lease)
        if jog.mode == "manual":
            self._move_part(press, speeds, picture.t, now)
        else:
            self._move_hand(press, picture.t, now)

    def _is_lost(self, jog: Jog) -> bool:
        """Tell whether it is not known where what a jog moves is."""
        return jog.mode == "shared" and self.seen.hand is None

    def _begin(self, press: Press, now: float) -> None:
        self._start, self._explained = self.seen.place, False
        self._led = self._wanted_grip = None
        if press.jog.mode == "shared" and self.seen.hand is not None:
            lease, step = self._times.lease, press.jog.step
            self._led = LedGoal(self.seen.hand, now, lease, step, self._caution)

    def _move_hand(self, press: Press, painted: float, now: float) -> None:
        """Move the goal ahead of the hand."""
        hand, led, jog = self.seen.hand, self._led, press.jog
        assert hand is not None, "the press would have been refused"
        assert led is not None, "made when the press began"
        limit, turn = self._speeds_of()
        to = None if jog.target is None else target_pose(jog.target, led.pose)
        if to is None:
            heading = self.seen.place.base[2]
            axes = axes_of(jog.frame, jog.camera, heading, hand, self._grip)
            motion = hand_motion(jog, axes, limit, turn)
        else:
            share = max(map(abs, jog.speeds))
            motion = motion_to(to, led.pose, limit * share, turn * share)
        piece = led.advance(motion, hand, now)
        if not led.gets_on:
            self._explain(press)
        grip = self._wanted_grip
        if grip is not None:
            piece = piece._replace(grip=grip.advance(jog, self.seen.gripper, now))
        self._link.lead(piece, self.seen.t)
        self._link.jog(press, painted, PartSpeeds(), piece.motion)
        if to is not None:
            over = is_at(hand, to)
        elif jog.step is not None and grip is not None and not any(jog.speeds):
            over = self._grip_is_done(press, grip, now)
        elif jog.step is not None:
            takes = jog.step / (limit if any(jog.speeds[:3]) else turn)
            over = led.arrived(hand) or now - press.began > self._times.step + takes
        else:
            over = False
        if over:
            self._end(press, self._presses.end("step"), now)

    def _explain(self, press: Press, speeds: Sequence[float] | None = None) -> None:
        """Say once that a press does not get on, and which joints are at their stops.

        With `speeds` of joints, in manual mode, only if one is to go beyond its stop.
        """
        if self._explained:
            return
        joints = ", ".join(map(str, at_stops(self._robot, self.seen.place.q, speeds)))
        if joints:
            key = "stands.stop" if speeds is None else "stands.joint"
            self._post(press.viewer, Said(key, {"joints": joints}))
        elif speeds is None:
            self._post(press.viewer, Said("stands.hand"))
        self._explained = bool(joints) or speeds is None

    def _speeds_of(self) -> tuple[float, float]:
        """Return the largest speeds of the hand [m/s, rad/s] in force."""
        assert self.seen.operator is not None, "the press would have been refused"
        limit = min(self.seen.operator.limit, self._limits.speed)
        return limit, self._limits.turn * limit / self._limits.speed

    def _move_part(self, press: Press, speeds: PartSpeeds, painted: float, now: float) -> None:
        speeds = speeds._replace(grip=grip_speed(press.jog, self._robot.gripper))
        self._link.jog(press, painted, speeds)
        if speeds.joints:
            self._explain(press, speeds.joints)
        grip = self._wanted_grip
        if grip is not None and not any(press.jog.speeds):
            if self._grip_is_done(press, grip, now):
                self._end(press, self._presses.end("step"), now)
            return
        way = way_between(self._start, self.seen.place, press.jog.part)
        if press.jog.step is not None:
            longest = self._times.step + press.jog.step / 0.01
            if step_done(press.jog, way, speeds) or now - press.began > longest:
                self._end(press, self._presses.end("step"), now)

    def _grip_is_done(self, press: Press, grip: WantedGrip, now: float) -> bool:
        """Tell whether a bounded step of the gripper is over, or takes too long."""
        jog, speed = press.jog, abs(grip_speed(press.jog, self._robot.gripper))
        if jog.step is None or not speed:
            return False
        takes = self._times.step + jog.step / speed
        return grip.is_done(jog, self.seen.gripper) or now - press.began > takes

    def let_go(self, viewer: int, number: int, now: float) -> None:
        """Take the release of a press."""
        press = self._presses.alive
        self._end(press, self._presses.let_go(viewer, number), now)

    def leave(self, viewer: int, now: float) -> None:
        """Take it that a viewer is gone."""
        press = self._presses.alive
        self._end(press, self._presses.leave(viewer), now)
        self.announce(self.drivers.leave(viewer))

    def stop(self, now: float) -> None:
        """End what moves and let nobody drive, since somebody stops the robot."""
        self.rest("halted", now)
        self.announce(self.drivers.revoke())

    def rest(self, why: str, now: float) -> None:
        """End what moves, for one of the reasons of `presses`."""
        press = self._presses.alive
        self._end(press, self._presses.end(why), now)
        self.marker = None

    def yielded(self, viewer: int, grant: bool, now: float) -> None:
        """Take a driver's answer to who asks to drive; what the driver holds ends with its yes."""
        change = self.drivers.answer(viewer, grant, now)
        if change is not None and grant:
            self.rest("driver", now)
        self.announce(change)

    def announce(self, change: Change | None) -> None:
        """Say to all who drives or asks to."""
        if change is not None:
            params = {} if change.viewer is None else {"viewer": change.viewer}
            self._post(None, Said(change.key, params))

    def _end(self, press: Press | None, ends: list[End], now: float) -> None:
        """Publish the end of a press that moved, and say why to its viewer."""
        for viewer, number, why, began in ends:
            self._post(viewer, Ended(number, f"press.{why}"))
            if not began:
                self._post(viewer, Said(f"refused.{why}", self._params(why), urgent=True))
            elif press is not None:
                self._link.release(press, self.seen.t)
                if press.jog.mode == "shared" and self.seen.hand is not None:
                    self._link.stand(pose_of(self.seen.hand), self.seen.t)
                    self._settles_until = now + _SETTLES
                if self._led is not None:
                    self._caution = self._led.caution
                self._led = None

    def _params(self, why: str) -> dict[str, str | float | int]:
        operator = self.seen.operator
        match why:
            case "driver":
                return {"driver": self.drivers.driver or 0}
            case "halted" if operator is not None:
                return {"by": operator.halted_by}
            case "mode" if operator is not None:
                return {"mode": operator.mode}
        return {}
