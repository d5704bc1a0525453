"""The browsers that look: what each is sent, and what each may send."""

import asyncio
from collections import deque
from contextlib import suppress
from typing import Protocol

from nodes.hmi.protocol.values import Role

_WINDOW = 10  # states that a browser may leave unanswered: half a second's worth
_PROBE = 1.0  # [s] from one state to the next for a browser that does not answer
_MOST_WAITING = 256  # messages but states that may wait for a slow browser
_RATE, _BURST = 100.0, 200.0  # messages a second that are read, and at once: five times what is due


class Socket(Protocol):
    """What a viewer needs of a connection."""

    async def send(self, message: bytes, *, text: bool) -> None:
        """Send a message, and wait while the other side does not take it."""

    async def close(self, code: int, reason: str) -> None:
        """Close the connection."""


class Rate:
    """Allows `_RATE` messages a second on average, and `_BURST` at once."""

    def __init__(self, now: float) -> None:
        self._left, self._last = _BURST, now

    def allows(self, now: float) -> bool:
        """Take one more message `now` [s]; return whether that is still within the rate."""
        self._left = min(self._left + (now - self._last) * _RATE, _BURST) - 1.0
        self._last = now
        return self._left >= 0.0


class Viewer:
    """One browser that looks.

    States never queue up: of those that it has not been sent yet only the newest is kept, and none
    is sent to a browser that does not answer by having painted those before. What else there is to
    say waits for it; a browser for which too much of that waits is cut off.

    Attributes:
        number: Which viewer.
        role: What it may do.
        painted: The number of the state that it painted last.
        rate: Of its messages.
        last_you: What it was last sent of itself, and when.
    """

    def __init__(self, number: int, role: Role, socket: Socket, now: float) -> None:
        self.number, self.role = number, role
        self.painted = 0
        self.rate = Rate(now)
        self.last_you: tuple[tuple[bool, int], float] = (False, -1), 0.0
        self._socket = socket
        self._waiting: deque[bytes] = deque()
        self._state: tuple[int, bytes] | None = None
        self._unanswered: deque[int] = deque()
        self._sent = -_PROBE  # when the last state was sent [s]
        self._wake = asyncio.Event()
        self._too_slow = False

    def post(self, message: bytes) -> None:
        """Send what is said once."""
        if len(self._waiting) >= _MOST_WAITING:
            self._too_slow = True
        else:
            self._waiting.append(message)
        self._wake.set()

    def show(self, number: int, state: bytes, now: float) -> bool:
        """Send a state if the browser keeps up; return whether it is to be sent."""
        if len(self._unanswered) >= _WINDOW and now - self._sent < _PROBE:
            return False
        if self._state is None:
            self._unanswered.append(number)
        self._state, self._sent = (number, state), now
        self._wake.set()
        return True

    def answered(self, number: int) -> None:
        """Note that it has painted a state, and so all before it."""
        self.painted = max(self.painted, number)
        while self._unanswered and self._unanswered[0] <= number:
            self._unanswered.popleft()

    async def write(self) -> None:
        """Send what there is to send until the connection is closed."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            while self._waiting and not self._too_slow:
                await self._socket.send(self._waiting.popleft(), text=True)
            if self._too_slow:
                with suppress(Exception):
                    await self._socket.close(1013, "too slow")
                return
            if self._state is not None:
                (_, state), self._state = self._state, None
                await self._socket.send(state, text=True)
