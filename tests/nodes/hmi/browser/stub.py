"""A small stand-in for the page's server and robot, for tests of the browser's side alone.

It serves the page, speaks the protocol, and moves a hand on a straight line while it gets jogs.
What the page sends is kept in `heard`. It decides little: whether the real robot stands still is
for the tests with the real server to say.
"""

import asyncio
import contextlib
import json
import mimetypes
import threading
import time
from collections.abc import Callable, Iterator
from http import HTTPStatus
from pathlib import Path
from typing import Any

from websockets.asyncio.server import Server, ServerConnection, broadcast, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

PAGE = Path(__file__).parents[4] / "nodes" / "hmi" / "page"
CSP = "default-src 'self'"
PERIOD = 0.05  # [s] from one state to the next
LEASE = 0.25  # [s] for which a jog moves the hand
SPEED = 0.15  # [m/s] of the hand at a share of 1

Json = dict[str, Any]


def hello(**more: Any) -> Json:
    """Return what a server says first, of a robot with a platform, two joints and a gripper."""
    upright = {"position": [0.0, 0.0, 0.5], "orientation": [0.0, 0.0, 0.0, 1.0]}
    forward = {"position": [0.35, 0.0, 0.0], "orientation": [0.0, 0.0, 0.0, 1.0]}
    middle = {"position": [0.17, 0.0, 0.0], "orientation": [0.0, 0.7071068, 0.0, 0.7071068]}
    moving = {"slides": False, "multiplier": 1.0, "offset": 0.0}
    solid = {"mesh": "", "colour": [0.3, 0.4, 0.5, 1.0]}
    joint = {"name": "a joint", "slides": False, "lower": -2.0, "upper": 2.0}
    return {
        "type": "hello",
        "version": 1,
        "robot": "stub",
        "role": "engineer",
        "viewer": 1,
        "language": "en",
        "base": "differential",
        "gripper": True,
        "joints": [joint, joint],
        "frames": [
            {**moving, "parent": 0, "origin": upright, "axis": [0.0, 0.0, 1.0], "leader": 0},
            {**moving, "parent": 1, "origin": forward, "axis": [0.0, 1.0, 0.0], "leader": 1},
        ],
        "tip": forward,
        "shapes": [
            {**solid, "kind": "box", "size": [0.6, 0.5, 0.45], "pose": upright, "frame": 0},
            {**solid, "kind": "cylinder", "size": [0.04, 0.35], "pose": middle, "frame": 1},
            {**solid, "kind": "sphere", "size": [0.05], "pose": forward, "frame": 2},
        ],
        "limits": {"speed": 0.25, "turn": 0.5, "joints": [1.0, 1.0], "platform": [0.5, 1.0]},
        "times": {
            **{"jog": 0.05, "lease": 0.25, "picture": 0.5, "idle": 5.0},
            **{"confirm": 0.5, "step": 3.0},
        },
        "places": {"mouth": upright, "table": upright},
        "tasks": ["fetch"],
        "faults": ["joint/1:locked", "joint/2:locked"],
        "processes": ["plant", "joint/1", "joint/2", "platform"],
        "happened": [{"t": 1.0, "key": "process.came", "params": {"role": "plant"}}],
        "rehearsal": {"hosts": ["robot", "arm", "base"], "shortest": 0.1, "longest": 8.0},
        **more,
    }


class Stub:
    """The server, in a thread with an event loop of its own.

    Attributes:
        heard: What browsers sent, with the time of arrival [s] as `at`.
        hello: What new browsers are told.
        mode: The mode in force.
        halted: Whether the robot is stopped.
        answers: Whether the robot answers; if not, no STOP is confirmed.
        silent: Whether nothing at all is sent.
        things: What stands around the robot.
        refusal: The key of the words and the parameters by which requests are refused; no key if
            they are carried out.
    """

    def __init__(self) -> None:
        self._talks = 0
        self._number = 0
        self.begin_anew()
        self._start = time.monotonic()
        self._ready = threading.Event()
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_until_complete, args=(self._run(),))
        self._thread.start()
        self._ready.wait()

    def begin_anew(self) -> None:
        """Be as at first, once nobody is connected any more."""
        wait_until(lambda: self._talks == 0, "the tabs of the test before are closed")
        self.heard: list[Json] = []
        self.hello = hello()
        self.mode = "rest"
        self.halted = False
        self.answers = True
        self.silent = False
        self.things: list[Json] = []
        self.refusal: tuple[str, Json] = ("", {})
        self._hand = [0.7, 0.0, 0.6]
        self._jog: tuple[Json, float] | None = None
        self._pressed = 0

    @property
    def address(self) -> str:
        """Where the operator's view is."""
        return f"http://127.0.0.1:{self._port}/"

    def of(self, kind: str) -> list[Json]:
        """Return what was heard of one type."""
        return [message for message in self.heard if message["type"] == kind]

    def close(self) -> None:
        """End it."""
        self._loop.call_soon_threadsafe(self._ending.set)
        self._thread.join()
        self._loop.close()

    def drop(self) -> None:
        """Close all connections, as a network does that is gone."""

        def close() -> None:
            for connection in self._server.connections:
                connection.transport.abort()

        self._loop.call_soon_threadsafe(close)

    def send(self, message: Json) -> None:
        """Send a message to all browsers."""
        text = json.dumps(message)
        self._loop.call_soon_threadsafe(lambda: broadcast(self._server.connections, text))

    async def _run(self) -> None:
        self._ending = asyncio.Event()
        async with serve(
            self._talk,
            "127.0.0.1",
            0,
            process_request=self._file,
            compression=None,
            open_timeout=None,  # on a busy machine a page would lack one of its files
        ) as self._server:
            self._port = next(iter(self._server.sockets)).getsockname()[1]
            self._ready.set()
            states = asyncio.create_task(self._states(self._server))
            await self._ending.wait()
            states.cancel()

    def _file(self, connection: ServerConnection, request: Request) -> Response | None:
        path = request.path.partition("?")[0]
        if path == "/socket":
            return None
        file = PAGE / (path.strip("/") or "index.html")
        if not file.is_file():
            return connection.respond(HTTPStatus.NOT_FOUND, "")
        kind = mimetypes.guess_type(file.name)[0] or "text/plain"
        body = file.read_bytes()
        headers = Headers(
            {
                "Content-Type": kind,
                "Content-Length": str(len(body)),
                "Content-Security-Policy": CSP,
                "Connection": "close",
            }
        )
        return Response(200, "OK", headers, body)

    async def _talk(self, connection: ServerConnection) -> None:
        self._talks += 1
        with contextlib.suppress(ConnectionClosed):
            await connection.send(json.dumps(self.hello))
            async for text in connection:
                message = json.loads(text)
                self.heard.append({**message, "at": time.monotonic()})
                for answer in self._answers(message):
                    await connection.send(json.dumps(answer))
        self._talks -= 1

    def _answers(self, message: Json) -> Iterator[Json]:
        kind = message["type"]
        if kind == "jog":
            if message["press"] > self._pressed:
                self._pressed = message["press"]
                self._jog = message, time.monotonic()
            elif self._jog is not None and self._jog[0]["press"] == message["press"]:
                self._jog = message, time.monotonic()
        elif kind == "let_go":
            self._jog = None
        elif kind == "halt" and self.answers:
            self.halted, self._jog = True, None
            yield {"type": "halted", "id": message["id"], "confirmed": True, "after": 0.01}
        elif "id" in message and kind != "halt":
            if kind == "mode":
                self.mode, self._jog = message["mode"], None
            if kind == "release":
                self.halted = False
            key, params = self.refusal
            yield {"type": "done", "id": message["id"], "ok": not key, "key": key, "params": params}

    async def _states(self, server: Server) -> None:
        while True:
            await asyncio.sleep(PERIOD)
            if self.silent:
                continue
            self._move(time.monotonic())
            self._number += 1
            broadcast(server.connections, json.dumps(self._state()))
            if self._number % 10 == 1:
                broadcast(server.connections, json.dumps(self._processes()))

    def _move(self, now: float) -> None:
        if self._jog is None or now - self._jog[1] > LEASE or self.halted:
            self._jog = None
            return
        for axis, share in enumerate(self._jog[0]["speeds"][:3]):
            self._hand[axis] += share * SPEED * PERIOD

    def _state(self) -> Json:
        pose = {"position": self._hand, "orientation": [0.0, 0.0, 0.0, 1.0]}
        return {
            "type": "state",
            "number": self._number,
            "t": time.monotonic() - self._start,
            "age": 0.0,
            "q": [0.3, 0.5],
            "base": [0.0, 0.0, 0.0],
            "hand": pose,
            "goal": pose,
            "error": 0.002,
            "gate": {
                "mode": self.mode,
                "halted": self.halted,
                "by": "viewer 1" if self.halted else "",
                "limit": 0.15,
                "age": None,
            },
            "driver": None,
            "asking": None,
            "viewers": 1,
            "things": self.things,
        }

    def _processes(self) -> Json:
        def row(role: str) -> Json:
            numbers = {"pid": 4242, "rate": 16.7, "answer": 0.002, "restarts": 0, "refused": 0}
            return {"role": role, "state": "runs", "says": "runs", "host": "here", **numbers}

        rows = [row(role) for role in self.hello["processes"]]
        return {"type": "processes", "rows": rows, "refused": {"token": 2}}


def wait_until(true: Callable[[], Any], what: str, deadline: float = 60.0) -> None:
    """Wait until something is true, [s] at most."""
    end = time.monotonic() + deadline
    while not true():
        assert time.monotonic() < end, f"still not so: {what}"
        time.sleep(0.01)


def hold_until_it_moves(stub: Stub, down: Callable[[], Any], up: Callable[[], Any]) -> int:
    """Press until some jogs of one press have arrived; return the press's number.

    On a busy machine the page may refuse a press (its picture is old) or end one by itself (what
    it sends would arrive late), and rightly so. A person then lets go and presses again.
    """

    def moves() -> bool:
        before = len(stub.heard)
        down()
        since = time.monotonic()
        while time.monotonic() - since < 2.0:
            kinds = [message["type"] for message in stub.heard[before:]]
            if "let_go" in kinds:
                break
            if kinds.count("jog") > 3:
                return True
            time.sleep(0.01)
        up()
        return False

    wait_until(moves, "jogs arrive")
    number: int = stub.of("jog")[-1]["press"]
    return number


def jog_by(stub: Stub, button: Any, key: str = "Space") -> Json:
    """Hold a key on a button until some jogs have arrived, let go; return the last of its jogs."""
    keys = button.page.keyboard
    button.focus()
    number = hold_until_it_moves(stub, lambda: keys.down(key), lambda: keys.up(key))
    keys.up(key)
    wait_until(lambda: [x["press"] for x in stub.of("let_go")].count(number) == 1, "it stops")
    return [each for each in stub.of("jog") if each["press"] == number][-1]
