"""The page's link to the robot: what it sees on the bus, and what it publishes there."""

import math
import time
from typing import Any

import numpy as np

from nodes.hmi.jogging import GoalPiece, Motion, PartSpeeds, Place
from nodes.hmi.presses import Press
from nodes.hmi.protocol.shape import Thing
from nodes.hmi.protocol.values import Pose
from nodes.hmi.seen import Seen, hand_of, things_of
from runtime.errors import NotConfirmed
from runtime.processes.node import Context
from runtime.processes.plant_clock import BusClock
from runtime.watching.control import Control
from runtime.watching.watcher import ProcessWatcher, goal_at
from runtime.wire import topics
from runtime.wire.arbitration import GoalInput, TopicInput
from runtime.wire.messages import (
    EndEffectorPose,
    GoalMessage,
    GripperState,
    PlatformPose,
)
from runtime.wire.operator_messages import JogMessage, OperatorState
from runtime.wire.samples import Sample
from runtime.wire.world_message import WorldMessage

FRESH = 0.5
"""Age from which on what the plant says counts as gone [s]: ten of its messages."""
_AT_ONCE = 8
_GOAL_FRESH = 0.5  # [s]
_CHANGES = 1.0  # [s] for the plant to say that it has changed its gate
_REST = Motion(np.zeros(3), np.zeros(3))


class RobotLink:
    """Sees the robot and publishes for the page; `look` as often as it is shown.

    Attributes:
        incarnation: The random number of this process, by which the robot knows its presses.
        processes: Which the robot has.

    Args:
        context: What the process of the node has.
        speed: Plant time per real time.
        lease: For how long a goal moves on by itself [s].
    """

    def __init__(self, context: Context, speed: float, lease: float) -> None:
        bus, refusals = context.bus, context.refusals
        self.incarnation = bus.incarnation
        self._bus, self._lease = bus, lease
        self._n, self._speed = context.robot.n, speed
        self._clock = BusClock(bus, time.monotonic())
        self._hand = TopicInput(topics.HAND, EndEffectorPose, FRESH, refusals)
        self._base = TopicInput(topics.PLATFORM, PlatformPose, FRESH, refusals)
        self._operator = TopicInput(topics.OPERATOR_STATE, OperatorState, FRESH, refusals)
        self._gripper = TopicInput(topics.GRIPPER, GripperState, FRESH, refusals)
        self._world = TopicInput(topics.WORLD, WorldMessage, FRESH, refusals)
        self._things: tuple[WorldMessage, tuple[Thing, ...]] | None = None  # of the last message
        self._goal = GoalInput(_GOAL_FRESH, refusals)
        inputs: list[TopicInput[Any]] = [self._hand, self._base, self._operator, self._gripper]
        inputs += [self._world]
        inputs += self._goal.inputs.values()
        self._inputs = [(bus.ring(each.key, _AT_ONCE), each) for each in inputs]
        self._jog_out = bus.publisher(topics.JOG)
        self._goal_out = bus.publisher(topics.GOAL)
        self._control = Control(bus)
        self._answered: OperatorState | None = None  # what the plant answered last
        self.processes = ProcessWatcher(bus)

    def look(self, now: float) -> Seen:
        """Return what is known `now` [s]."""
        for ring, source in self._inputs:
            arrivals: list[Sample] = list(ring.waiting(_AT_ONCE))
            for arrival in arrivals:
                source.accept(arrival.data, now)
        t, states = self._clock.look(now), self._clock.states.fresh(now)
        t = t if states is None else states.t
        q: tuple[float | None, ...] = (None,) * self._n
        if states is not None and len(states.position) == self._n:
            q = states.position
        base, pose = self._base.fresh(now), self._hand.fresh(now)
        place = Place(q, (0.0, 0.0, 0.0) if base is None else (base.x, base.y, base.heading))
        hand = None if pose is None else hand_of(pose.position, pose.orientation)
        message = self._goal.selected(now)
        goal = error = None
        if message is not None:
            at = goal_at(message, t)
            goal = Pose(at, message.orientation)
            error = None if pose is None else math.dist(pose.position, at)
        age = now - self._clock.arrived
        known = base is not None
        operator, answered = self._operator.fresh(now), self._answered
        if operator is not None and answered is not None and answered.t > operator.t:
            operator = answered  # what is published may be on its way still
        gripper = self._gripper.fresh(now)
        things = self._seen_things(now)
        return Seen(t, age, place, known, hand, goal, error, operator, gripper, things)

    def _seen_things(self, now: float) -> tuple[Thing, ...]:
        """Return the objects around the robot; made anew only by the next message."""
        world = self._world.fresh(now)
        if world is None:
            return ()
        if self._things is None or self._things[0] is not world:
            self._things = world, things_of(world)
        return self._things[1]

    def jog(self, press: Press, t: float, speeds: PartSpeeds, motion: Motion = _REST) -> None:
        """Publish that a press is held, in answer to a state of plant time `t` [s]."""
        forward, turning, sideways = speeds.platform
        self._jog_out.send(
            JogMessage(
                t,
                press=press.serial,
                mode=press.jog.mode,
                velocity=tuple(motion.linear.tolist()),
                angular_velocity=tuple(motion.angular.tolist()),
                joints=speeds.joints,
                linear=forward,
                angular=turning,
                lateral=sideways,
                grip=speeds.grip,
            )
        )

    def release(self, press: Press, t: float) -> None:
        """Publish that a press is over."""
        self._jog_out.send(JogMessage(t, press=press.serial, mode=press.jog.mode, held=False))

    def lead(self, piece: GoalPiece, t: float) -> None:
        """Publish a goal that moves for as long as it lasts, as of plant time `t` [s]."""
        speed = self._speed  # of plant time
        linear, angular = (tuple((one / speed).tolist()) for one in piece.motion)
        position, orientation = (tuple(one.tolist()) for one in piece.pose)
        until = t + min(piece.lasts, self._lease) * speed
        goal = GoalMessage(t, position, linear, t, until, orientation, angular, grip=piece.grip)
        self._goal_out.send(goal)

    def stand(self, pose: Pose, t: float) -> None:
        """Publish a goal that stands, as of plant time `t` [s]."""
        still = (0.0, 0.0, 0.0)
        self._goal_out.send(GoalMessage(t, pose.position, still, t, t, pose.orientation))

    def halt(self, by: str, timeout: float) -> bool:
        """Ask the robot to stop; return whether it has said within `timeout` [s] that it is."""
        try:
            self._answered = self._control.halt(by, timeout).state
        except NotConfirmed:
            return False
        return self._answered.halted

    def end_halt(self) -> None:
        """Release the robot, which rests; `RunError` if its plant does not say that it has."""
        self._answered = self._control.release(_CHANGES).state

    def choose(self, mode: str, limit: float | None = None) -> None:
        """Choose the mode, and perhaps a limit of speed [m/s]; `RunError` if that is refused."""
        self._answered = self._control.mode(mode, limit, _CHANGES).state

    def cut_off(self, host: str, seconds: float) -> None:
        """Have a host cut off from all others for so long [s]; `RunError` if that is refused."""
        self._control.partition([host], seconds)
