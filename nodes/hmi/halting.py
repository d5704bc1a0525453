"""STOP: asked of the robot until the robot confirms it."""

import asyncio
from collections import deque
from collections.abc import Callable
from concurrent.futures import Executor
from time import monotonic

from msgspec import Struct

from nodes.hmi.protocol.outgoing import Halted

_AGAIN = 0.05  # [s] before the robot is asked again
_KEPT = 64  # stops that were confirmed and are known: of more browsers than there can be


class Halting:
    """Halts the robot for whoever asks, and says to each when the robot has confirmed it.

    Args:
        ask: Asks the robot, in a thread, for somebody; returns whether it confirms within a time.
        post: Sends a message to a viewer.
        executor: With a thread that nothing else uses, so that nothing else keeps it waiting.
        confirm: Time after which a stop counts as not confirmed [s].
        failed: Counts attempts that failed by an error, by reason and detail.
    """

    def __init__(
        self,
        ask: Callable[[str, float], bool],
        post: Callable[[int, Struct], None],
        executor: Executor,
        confirm: float,
        failed: Callable[[str, str], None],
    ) -> None:
        self._ask, self._post, self._executor, self._confirm = ask, post, executor, confirm
        self._failed = failed
        self._waiting: dict[tuple[int, int], float] = {}  # since when, by viewer and id
        self._late: set[tuple[int, int]] = set()
        self._confirmed = deque[tuple[int, int]](maxlen=_KEPT)
        self._task: asyncio.Task[None] | None = None

    def halt(self, viewer: int, id_: int) -> None:
        """Begin to ask, unless the same was asked for already.

        A browser sends a stop again until it hears the answer. What it sent in the meantime is no
        new stop, and would halt a robot that somebody has released since.
        """
        if (viewer, id_) in self._confirmed:
            return
        self._waiting.setdefault((viewer, id_), monotonic())
        if self._task is None or self._task.done():
            self._task = asyncio.ensure_future(self._go_on(f"viewer {viewer} of the page"))

    def withdraw(self) -> None:
        """Ask no more, since somebody wants to release the robot."""
        self._waiting.clear()
        self._late.clear()

    def look(self, now: float) -> None:
        """Say what is not confirmed `now` [s]."""
        for key, since in self._waiting.items():
            if now - since >= self._confirm and key not in self._late:
                self._late.add(key)
                self._post(key[0], Halted(key[1], False, now - since))

    async def _go_on(self, by: str) -> None:
        loop = asyncio.get_running_loop()
        while self._waiting:
            asked = set(self._waiting)
            try:
                confirmed = await loop.run_in_executor(self._executor, self._ask, by, self._confirm)
            except Exception as error:  # whatever it is, it must not keep this from asking again
                confirmed = False
                self._failed("failed", f"to halt: {type(error).__name__}: {error}")
            now = monotonic()
            self.look(now)
            for viewer, id_ in asked & self._waiting.keys() if confirmed else ():
                since = self._waiting.pop((viewer, id_))
                self._late.discard((viewer, id_))
                self._confirmed.append((viewer, id_))
                self._post(viewer, Halted(id_, True, now - since))
            if self._waiting:
                await asyncio.sleep(_AGAIN)
