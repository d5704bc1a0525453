"""What connects the viewers with the robot: it shows them the robot, and takes what they send."""

import asyncio
import time
from concurrent.futures import Executor
from contextlib import suppress
from itertools import count
from typing import TYPE_CHECKING, Any

import msgspec
from websockets.asyncio.server import Server, ServerConnection

from nodes.hmi.door import Door
from nodes.hmi.doorkeeper import Doorkeeper
from nodes.hmi.driving import Driving
from nodes.hmi.halting import Halting
from nodes.hmi.hello import (
    faults_of,
    frames_of,
    joints_of,
    limits_of,
    meshes_of,
    pose_of,
    rehearsal_of,
    shapes_of,
)
from nodes.hmi.places import SavedPlaces, places_file
from nodes.hmi.protocol.incoming import Halt, Incoming, Jog, LetGo, Painted, Takeover, Yield
from nodes.hmi.protocol.outgoing import Gate, Hello, Processes, Said, State, You
from nodes.hmi.protocol.values import VERSION, Role, Times
from nodes.hmi.record import ProcessTable, Record
from nodes.hmi.requests import Requests, tasks_of
from nodes.hmi.robot_link import RobotLink
from nodes.hmi.seen import Seen, rounded
from nodes.hmi.seen import pose_of as pose_of_hand
from nodes.hmi.viewers import Viewer
from runtime.config.deployment import Deployment
from runtime.processes.node import Context
from runtime.wire.topics import GRIPPER_AGENT

if TYPE_CHECKING:  # a page that encrypts nothing does without
    import ssl

TIMES = Times()
_TABLE = 1.0  # [s] from one table of the processes to the next
_YOU = 0.25  # [s] the same of what concerns a viewer that drives
_FLOODED = 1008  # close code of the WebSocket protocol: a policy was violated
_KEY = "page"
"""Under which `msma status` counts what the page refuses."""


class Hub:
    """All that goes on between the page's viewers and the robot.

    Args:
        context: What the process of the node has.
        language: Of the page.
        halts: With a thread for stopping alone.
        requests: With threads for other questions to the robot.
    """

    def __init__(
        self,
        context: Context,
        language: str,
        halts: Executor,
        requests: Executor,
    ) -> None:
        deployment: Deployment = context.deployment
        self._context, self._deployment, self._language = context, deployment, language
        self._viewers: dict[int, Viewer] = {}
        self._tasks = set[asyncio.Task[None]]()
        self._numbers, self._states = count(1), count(1)
        self._encoder = msgspec.json.Encoder()
        self._decoder = msgspec.json.Decoder(Incoming)
        self._link = RobotLink(context, deployment.speed, TIMES.lease)
        limits = limits_of(context.robot)
        seen = self._link.look(time.monotonic())
        grips = GRIPPER_AGENT in deployment.roles
        self._driving = Driving(context.robot, limits, TIMES, self._link, self._post, seen, grips)
        self._places = SavedPlaces(places_file(deployment.robot))
        self._record = Record(context.log, self._post)
        if self._places.error:
            context.log.write(context.t, "places", error=self._places.error)
        self._halting = Halting(self._link.halt, self._post, halts, TIMES.confirm, self._refuse)
        self._requests = Requests(
            context,
            self._link,
            self._driving,
            self._halting,
            self._places,
            self._record,
            self._post,
            requests,
        )
        self._processes = ProcessTable(deployment.roles)
        self._next_table = 0.0
        self._server: Server | None = None

    @property
    def is_watched(self) -> bool:
        """Whether anybody looks."""
        return bool(self._viewers)

    async def open(
        self, keeper: Doorkeeper, listen: str, port: int, tls: "ssl.SSLContext | None"
    ) -> None:
        """Begin to serve; `OSError` if the port cannot be had."""
        self._server = await Door(keeper, self._refuse, self._meet).open(listen, port, tls)

    async def close(self) -> None:
        """End what moves, and all connections."""
        now = time.monotonic()
        with suppress(Exception):  # the bus may be closed, and then the robot knows by itself
            self._driving.rest("released", now)
        if self._server is not None:
            self._server.close(code=1001, reason="the page ends")
            await self._server.wait_closed()
        for task in self._tasks:
            task.cancel()

    def turn(self, now: float) -> None:
        """Look at the robot `now` [s], and show it."""
        seen = self._link.look(now)
        self._driving.look(seen, now)
        self._record.look(seen.operator)
        self._halting.look(now)
        if self._viewers:
            self._show(seen, now)
        if now >= self._next_table:
            self._next_table = now + _TABLE
            self._show_processes(seen, now)

    def _show(self, seen: Seen, now: float) -> None:
        number = next(self._states)
        state = self._encoder.encode(self._state(number, seen))
        self._driving.pictures.sent(number, now, seen.t)
        for viewer in list(self._viewers.values()):
            viewer.show(number, state, now)
            self._show_you(viewer, now)

    def _state(self, number: int, seen: Seen) -> State:
        drivers, operator, hand = self._driving.drivers, seen.operator, seen.hand
        gate = None
        if operator is not None:
            halted, by = operator.halted, operator.halted_by
            gate = Gate(operator.mode, halted, by, operator.limit, operator.age)
        return State(
            number,
            round(seen.t, 4),
            round(seen.age, 3),
            tuple(None if one is None else round(one, 5) for one in seen.place.q),
            tuple(round(one, 5) for one in seen.place.base) if seen.base_known else None,
            None if hand is None else rounded(pose_of_hand(hand)),
            None if seen.goal is None else rounded(seen.goal),
            None if seen.error is None else round(seen.error, 5),
            gate,
            drivers.driver,
            drivers.asking,
            len(self._viewers),
            seen.things,
        )

    def _show_you(self, viewer: Viewer, now: float) -> None:
        driving = self._driving.drivers.driver == viewer.number
        press = self._driving.press_of(viewer.number)
        said, when = viewer.last_you
        if said == (driving, press) and not (driving and now - when >= _YOU):
            return
        viewer.last_you = (driving, press), now
        age = self._driving.pictures.age(viewer.painted, now)
        viewer.post(self._encoder.encode(You(driving, press, age and round(age, 3))))

    def _show_processes(self, seen: Seen, now: float) -> None:
        rows = self._processes.look(self._link.processes.rows(), now)
        for role, key in self._processes.changes(rows).items():
            self._record.note(seen.t, key, role=role)
        engineers = [one for one in self._viewers.values() if one.role == "engineer"]
        if engineers:
            refused = self._context.refusals.table().get(_KEY, {})
            table = self._encoder.encode(Processes(rows, refused))
            for viewer in engineers:
                viewer.post(table)

    def _post(self, to: int | None, message: Any) -> None:
        """Send a message to a viewer if it is there, or to all."""
        encoded = self._encoder.encode(message)
        for viewer in list(self._viewers.values()):
            if to in (None, viewer.number):
                viewer.post(encoded)

    def _refuse(self, reason: str, detail: str) -> None:
        self._context.refusals.count(_KEY, reason, detail)

    async def _meet(self, connection: ServerConnection, role: Role) -> None:
        """Show a viewer the robot, and take what it sends, until it leaves."""
        viewer = Viewer(next(self._numbers), role, connection, time.monotonic())
        viewer.post(self._encoder.encode(self._hello(viewer)))
        self._viewers[viewer.number] = viewer
        writing = asyncio.ensure_future(viewer.write())
        try:
            async for frame in connection:
                now = time.monotonic()
                if not viewer.rate.allows(now):
                    self._refuse("flood", f"viewer {viewer.number}")
                    await connection.close(_FLOODED, "too many messages")
                    break
                self._take(viewer, frame, now)
        finally:
            del self._viewers[viewer.number]
            self._driving.leave(viewer.number, time.monotonic())
            writing.cancel()
            with suppress(asyncio.CancelledError, Exception):
                await writing

    def _take(self, viewer: Viewer, frame: str | bytes, now: float) -> None:
        """Act on a frame that arrived `now` [s]."""
        try:
            message: Incoming = self._decoder.decode(frame)
        except (msgspec.MsgspecError, UnicodeDecodeError, RecursionError) as error:
            self._refuse("malformed", str(error)[:200])
            viewer.post(self._encoder.encode(Said("refused.message", {"why": str(error)[:200]})))
            return
        driving, number = self._driving, viewer.number
        match message:
            case Jog():
                viewer.answered(message.state)
                driving.seen = self._link.look(now)
                driving.jog(number, message, now)
                self._show_you(viewer, now)
            case Painted(state=state):
                viewer.answered(state)
            case LetGo(press=press):
                driving.let_go(number, press, now)
                self._show_you(viewer, now)
            case Halt(id=id_):
                driving.stop(now)
                self._halting.halt(number, id_)
            case Takeover():
                driving.announce(driving.drivers.ask(number, now))
            case Yield(grant=grant):
                driving.yielded(number, grant, now)
            case _:
                task = asyncio.ensure_future(self._requests.carry_out(viewer, message))
                self._tasks.add(task)
                task.add_done_callback(self._tasks.discard)

    def _hello(self, viewer: Viewer) -> Hello:
        robot, of = self._context.robot, self._deployment
        return Hello(
            VERSION,
            of.robot,
            viewer.role,
            viewer.number,
            self._language,
            "fixed" if robot.drive is None else robot.drive.kind,
            robot.gripper is not None,
            joints_of(robot),
            frames_of(robot),
            pose_of(robot.tip),
            shapes_of(robot, meshes_of(robot.visuals)),
            limits_of(robot),
            TIMES,
            self._places.poses,
            tasks_of(of),
            faults_of(robot),
            of.roles,
            tuple(self._record.lines),
            rehearsal_of(of),
        )
