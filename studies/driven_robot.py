"""A robot that a person drives, in lockstep: the page's part of it, the gate, agents and plant."""

import numpy as np
from msgspec import Struct
from msgspec.structs import replace

from agents.agent import Agent, Array, Body, Goal, Percepts
from agents.joint import JointAgent
from agents.platform import PlatformAgent
from nodes.hmi.driving import Driving
from nodes.hmi.hello import limits_of
from nodes.hmi.jogging import GoalPiece, Hand, Motion, PartSpeeds, Place
from nodes.hmi.presses import Press
from nodes.hmi.protocol.incoming import Jog
from nodes.hmi.protocol.values import Pose, Times
from nodes.hmi.seen import Seen
from plant.kinematic import KinematicPlant
from plant.kinematics import quaternion
from plant.plant import Commands, Setup
from plant.robot import numbers
from runtime.gate.gate import Gate
from runtime.gate.speed_limit import SpeedLimit
from runtime.processes.timing import freshness
from runtime.wire.operator_messages import JogMessage, Mode
from studies.lockstep import decide_all, true_motion
from studies.mobile import ARPH, PERIOD

ASIDE = np.radians(90.0)
"""Bearing of the hand when lined up, in deploy/arph-web.yaml [rad]."""
NEAR = 0.35
"""Comfortable reach of the hand there, as a share of the arm's length."""
TIMES = Times()
VIEWER = 1  # the only one
_SOON = 1e-9  # [s] by which two moments may differ and still be the same


def web_team(seed: int) -> dict[str, Agent]:
    """Return the agents of deploy/arph-web.yaml, but that of the gripper."""
    agents: dict[str, Agent] = {}
    for joint in range(ARPH.n):
        body = Body(ARPH, joint, PERIOD, [seed, joint])
        agents[f"joint/{joint + 1}"] = JointAgent(body)
    body = Body(ARPH, None, PERIOD, [seed, ARPH.n])
    agents["platform"] = PlatformAgent(body, bearing=ASIDE, reach=NEAR)
    return agents


class _Link:
    """What the page publishes goes to the gate and to the agents at once."""

    incarnation = 0

    def __init__(self, gate: Gate) -> None:
        self._gate = gate
        self.now, self.t = 0.0, 0.0  # of what is published, and of the state in the plant [s]
        self.goal: Goal | None = None
        self.published = 0.0  # when the goal was [s]

    def jog(self, press: Press, t: float, speeds: PartSpeeds, motion: Motion | None = None) -> None:
        forward, turning, _ = speeds.platform
        mode, joints = press.jog.mode, speeds.joints
        message = JogMessage(t, press=press.serial, mode=mode, joints=joints)
        self._send(replace(message, linear=forward, angular=turning))

    def release(self, press: Press, t: float) -> None:
        self._send(JogMessage(t, press=press.serial, mode=press.jog.mode, held=False))

    def _send(self, message: JogMessage) -> None:
        self._gate.jog(message, self.now, self.t - message.t)

    def lead(self, piece: GoalPiece, t: float) -> None:
        (position, orientation), (linear, angular) = piece.pose, piece.motion
        self._lead(Goal(position, linear, t, t + piece.lasts, orientation, angular))

    def stand(self, pose: Pose, t: float) -> None:
        turn = None if pose.orientation is None else np.array(pose.orientation)
        self._lead(Goal(np.array(pose.position), np.zeros(3), t, t, turn))

    def _lead(self, goal: Goal) -> None:
        self.goal, self.published = goal, self.now


class DrivenRobot:
    """The robot of deploy/arph-web.yaml, which moves while a person holds a button.

    Each state of the plant is seen by the page from the next moment on, and agents follow what the
    page published last, in the same period.

    Attributes:
        plant: The robot itself.
        agents: By role.
        seen: What the page shows.

    Args:
        q: (6,) joint angles at the start [rad].
        base: (3,) of the platform at the start [m], [rad].
        mode: `shared` or `manual`.
        limit: Largest speed of the hand [m/s].
        seed: Of all random numbers.
    """

    def __init__(self, q: Array, base: Array, mode: Mode, limit: float, seed: int) -> None:
        self.plant = KinematicPlant(Setup(ARPH, q, base, period=PERIOD, seed=[seed, 1000]))
        self.agents = web_team(seed)
        self._gate, self._speed_limit = Gate("rest"), SpeedLimit(ARPH, PERIOD)
        self._gate.choose(mode, limit)
        self._link, self._now, self._ticks, self._looks = _Link(self._gate), 0.0, 0, 0
        self._jog: Jog | None = None
        self._presses = 0
        self.seen = self._look()
        args = ARPH, limits_of(ARPH), TIMES, self._link, self._said, self.seen
        self._driving = Driving(*args, has_gripper_agent=False)
        self.go_on(0.0)

    def _said(self, _: int | None, message: Struct) -> None:
        """Take what the page is told: nothing that a person here needs."""

    @property
    def hand(self) -> Hand:
        """Where the hand truly is."""
        truth = true_motion(self.plant)
        turned = np.reshape(np.array(truth.rotation), (3, 3))
        return Hand(np.array(truth.position), quaternion(turned))

    @property
    def holds(self) -> bool:
        """Whether a press moves the robot."""
        return self._driving.press_of(VIEWER) > 0

    def hold(self, part: str, speeds: tuple[float, ...], camera: float = 0.0) -> None:
        """Press a button: see `Jog` for what it moves, in the frame of the person's view."""
        self._presses += 1
        mode = self._gate.mode
        assert mode in ("shared", "manual")
        self._jog = Jog(self._presses, 1, mode, part, speeds, "mine", camera)
        self._send()

    def let_go(self) -> None:
        """Let go of the button."""
        self._jog = None
        self._driving.let_go(VIEWER, self._presses, self._now)

    def _send(self) -> None:
        if self._jog is not None:
            self._jog = replace(self._jog, state=self._looks)
            self._driving.jog(VIEWER, self._jog, self._now)

    def go_on(self, seconds: float) -> None:
        """Let so much time pass [s]."""
        until = self._now + seconds + _SOON
        while True:
            tick, look = self._ticks * PERIOD, self._looks * TIMES.jog
            if min(tick, look) > until:
                break
            self._now = self._link.now = min(tick, look)
            if look <= tick + _SOON:
                self._show()
            else:
                self._tick()
        self._now = self._link.now = until - _SOON

    def _show(self) -> None:
        """The page shows the newest state, and the person's browser answers it."""
        self._looks += 1
        self._driving.look(self.seen, self._now)
        self._driving.pictures.sent(self._looks, self._now, self.seen.t)
        self._send()

    def _tick(self) -> None:
        """Let agents decide, and the robot move for a period."""
        self._ticks += 1
        readings, gate, link = self.plant.read(), self._gate, self._link
        held, none = gate.held(self._now), Commands((0.0,) * ARPH.n, (0.0, 0.0))
        wanted = none
        if gate.mode == "shared":
            fresh = self._now - link.published <= freshness(PERIOD, 1.0)
            percepts = Percepts.of(readings, link.goal if fresh else None)
            decided = decide_all(self.agents, percepts, (ARPH.n,))
            if held is not None:
                wanted = Commands(numbers(decided.joints), numbers(decided.base))
        elif held is not None:
            wanted = Commands(held.joints or none.joints, (held.linear, held.angular))
        share, q = gate.speed_share(self._now), numbers(readings.q)
        self.plant.write(self._speed_limit.limited(wanted, q, gate.limit, share))
        self.seen, link.t = self._look(), readings.t
        self._driving.seen = self.seen
        self.plant.step()

    def _look(self) -> Seen:
        """Return the state of the plant as the page shows it."""
        readings = self.plant.read()
        assert readings.base is not None
        x, y, heading = numbers(readings.base)
        place = Place(numbers(readings.q), (x, y, heading))
        operator = self._gate.state(readings.t, self._now)
        return Seen(readings.t, 0.0, place, True, self.hand, None, None, operator)
