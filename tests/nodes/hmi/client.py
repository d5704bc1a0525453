"""A client of the page's socket in place of a browser: it answers each state as if painted."""

import json
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager, suppress
from typing import Any, Self, TypeVar
from urllib.parse import urlsplit

from websockets.exceptions import ConnectionClosed
from websockets.sync.client import ClientConnection, connect

from nodes.hmi.address import Address
from tests.runtime.conftest import DEADLINE, wait_for

JOG = 0.05  # [s]
Message = dict[str, Any]
T = TypeVar("T")


def open_socket(
    address: Address, token: str | None = None, **options: Any
) -> AbstractContextManager[ClientConnection]:
    """Open the socket as the page does; `options` replace what a browser would send."""
    url, options = as_browser(address, token, **options)
    opened: AbstractContextManager[ClientConnection] = connect(url, **options)
    return opened


def as_browser(
    address: Address, token: str | None = None, **options: Any
) -> tuple[str, dict[str, Any]]:
    """Return where the socket is, and what a browser would send, but for `options`."""
    headers = {"Cookie": f"msma-{address.port}={token or address.operator}"}
    usual = {"origin": address.origin, "additional_headers": headers, "compression": None}
    return f"{address.origin.replace('http', 'ws', 1)}/socket", usual | options


def listens(address: Address) -> bool:
    """Tell whether the page's socket is open: one that was revived is alive a little before."""
    with socket.socket() as one:
        return one.connect_ex((urlsplit(address.origin).hostname, address.port)) == 0


class Browser:
    """One browser: keeps the last message of each type, and all others."""

    def __init__(self, address: Address, token: str | None = None) -> None:
        self.last: dict[str, Message] = {}
        self.all: list[Message] = []
        self.paints = True
        self.presses = self.ids = 0
        self._stack = ExitStack()
        self._socket = self._stack.enter_context(open_socket(address, token))
        self._thread = threading.Thread(target=self._read, daemon=True)
        self._thread.start()

    def __enter__(self) -> Self:
        wait_for(lambda: "state" in self.last, "the page's first state")
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()
        self._thread.join()

    def _read(self) -> None:
        try:
            for frame in self._socket:
                message = json.loads(frame)
                if message["type"] == "state" and self.paints:
                    self.send("painted", state=message["number"])
                else:
                    self.all.append(message)
                self.last[message["type"]] = message
        except ConnectionClosed:
            pass

    @property
    def state(self) -> Message:
        return self.last["state"]

    @property
    def hand(self) -> list[float]:
        """Where the hand is [m], once the page sees it: of a plant that is late it does not."""
        hand: list[float] = self.wait_state(lambda one: one["hand"], "the hand")["hand"]["position"]
        return hand

    def send(self, kind: str, **fields: Any) -> None:
        with suppress(ConnectionClosed):
            self._socket.send(json.dumps({"type": kind, **fields}))

    def ask(self, kind: str, **fields: Any) -> Message:
        """Send a request and return what answers it."""
        self.ids += 1
        id_, answer = self.ids, "halted" if kind == "halt" else "done"
        self.send(kind, id=id_, **fields)
        # a halt that a busy plant is late to confirm is asked for again, by the page itself
        return self.wait(answer, lambda one: one["id"] == id_ and one.get("confirmed", True))

    def begin(self, mode: str, limit: float | None = None) -> None:
        """Choose a mode, and perhaps a limit [m/s]: a plant that is busy is asked again."""
        wait_for(lambda: self.ask("mode", mode=mode)["ok"], f"mode {mode}")
        if limit is not None:
            wait_for(lambda: self.ask("limit", limit=limit)["ok"], "the limit")
            self.wait_state(lambda one: one["gate"] and one["gate"]["limit"] == limit, "the limit")

    def wait(
        self, kind: str, fits: Callable[[Message], bool] = lambda _: True, timeout: float = DEADLINE
    ) -> Message:
        def found() -> list[Message]:
            return [one for one in list(self.all) if one["type"] == kind and fits(one)]

        self.wait_for(found, f"a message {kind}", timeout)
        return found()[-1]

    def wait_state(self, fits: Callable[[Message], bool], what: str) -> Message:
        """Wait for a state that fits, and return that very one: the next may not fit any more."""
        return self.wait_for(lambda: state if fits(state := self.state) else None, what)

    def wait_for(self, look: Callable[[], T | None], what: str, timeout: float = DEADLINE) -> T:
        """Wait for anything, and if it is in vain say what the page has told."""
        try:
            return wait_for(look, what, timeout)
        except AssertionError as error:
            told = [*self.all[-5:], self.last.get("state")]
            is_connected = self._thread.is_alive()
            raise AssertionError(f"{error}; connected: {is_connected}, told: {told}") from None

    def jog(self, press: int, *speeds: float, mode: str = "shared", **fields: Any) -> None:
        self.send(
            "jog", press=press, state=self.state["number"], mode=mode, speeds=speeds, **fields
        )

    @contextmanager
    def holding(self, *speeds: float, **fields: Any) -> Iterator[int]:
        """Hold a button, in a thread, until the end of the block; the press is then released."""
        self.presses += 1
        press, over = self.presses, threading.Event()

        def hold() -> None:
            while not over.is_set():
                self.jog(press, *speeds, **fields)
                time.sleep(JOG)

        holder = threading.Thread(target=hold)
        holder.start()
        try:
            yield press
        finally:
            over.set()
            holder.join()
            self.send("let_go", press=press)
