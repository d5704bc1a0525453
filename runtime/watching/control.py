"""What can be asked of the processes of a run and done to them, by verbs, chaos and others."""

import time
from collections.abc import Iterable
from typing import NamedTuple

from plant.faults import FaultError
from runtime.errors import NotConfirmed, RunError
from runtime.spawning.local import ProcessGroup
from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.operator_messages import STANDS_STILL, STOOD_STILL, OperatorState
from runtime.wire.packing import unpack_valid

_ANSWER = 1.0  # [s] to wait for the answer to a request
_CONFIRMED = 0.5  # [s] after which a request to halt, release or choose a mode is not confirmed
_PAUSE = 0.01  # [s] between two attempts to ask a plant that is not connected yet


class Confirmation(NamedTuple):
    """What the plant says after it has acted on a request, and how long that took [s]."""

    state: OperatorState
    after: float


class Control:
    """Acts on a run: on its processes by signals, on what answers on the bus by requests.

    Args:
        processes: The processes that were started or found; None if requests are enough.
        timeout: How long a request waits for its answer [s].
    """

    def __init__(
        self, bus: Bus, processes: ProcessGroup | None = None, timeout: float = _ANSWER
    ) -> None:
        self._bus, self._processes, self._timeout = bus, processes, timeout

    @property
    def processes(self) -> ProcessGroup:
        """The processes of the run, to be signalled and revived."""
        assert self._processes is not None, "made for requests only"
        return self._processes

    def stop(self, role: str = "**") -> bool:
        """Ask all processes of a role to stop, by default all; return whether any agrees."""
        return any(answer.agreed for answer in self._bus.ask(topics.stop(role), b"", self._timeout))

    def halt(self, by: str, timeout: float = _CONFIRMED) -> Confirmation:
        """Bring the robot to rest and keep it there until it is released; `by` is for people.

        `NotConfirmed` if its plant does not say within `timeout` [s] that it has: it may go on.
        """
        return self._confirmed(topics.HALT, by, timeout)

    def release(self, timeout: float = _CONFIRMED) -> Confirmation:
        """End a halt; the robot stays at rest. `NotConfirmed` as by `halt`."""
        return self._confirmed(topics.RELEASE, "", timeout)

    def mode(
        self, mode: str, limit: float | None = None, timeout: float = _CONFIRMED
    ) -> Confirmation:
        """Choose who moves the robot, and how fast near people [m/s], by default as before.

        `RunError` if its plant refuses that, `NotConfirmed` as by `halt`.
        """
        text = mode if limit is None else f"{mode} {limit!r}"
        return self._confirmed(topics.MODE, text, timeout)

    def _confirmed(self, key: str, text: str, timeout: float) -> Confirmation:
        """Ask until the plant has acted, also one that is held up: all these may be repeated."""
        began, refused = time.monotonic(), False
        while (left := began + timeout - time.monotonic()) > 0:
            for answer in self._bus.answers(key, text.encode(), min(left, _CONFIRMED)):
                if not answer.agreed:
                    said = answer.data.decode(errors="replace")
                    if said not in (STOOD_STILL, STANDS_STILL):
                        raise RunError(said)
                    refused = said == STOOD_STILL  # the other is no answer: it may act on it yet
                elif (state := unpack_valid(OperatorState, answer.data)) is not None:
                    return Confirmation(state, time.monotonic() - began)
            time.sleep(_PAUSE)
        raise RunError(STOOD_STILL) if refused else NotConfirmed(timeout)

    def fault(self, text: str) -> str:
        """Ask the plant for a fault, such as `joint/1:locked`, and return its answer.

        `RunError` if no plant answers, `FaultError` if it has no such fault.
        """
        agreed, said = self._ask_one(topics.FAULT, text, "plant")
        if not agreed:
            raise FaultError(said)
        return said

    def partition(self, hosts: Iterable[str], seconds: float) -> str:
        """Ask the launcher of a rehearsal to cut hosts off from the others for so long [s].

        Returns its answer; `RunError` if it refuses that, or none answers.
        """
        request = f"{','.join(hosts)} {seconds!r}"
        agreed, said = self._ask_one(topics.PARTITION, request, "launcher")
        if not agreed:
            raise RunError(said)
        return said

    def _ask_one(self, key: str, text: str, who: str) -> tuple[bool, str]:
        """Return whether the one that answers agrees, and what it says."""
        answers = self._bus.ask(key, text.encode(), self._timeout)
        if not answers:
            raise RunError(f"no {who} answers")
        return answers[0].agreed, answers[0].data.decode(errors="replace")
