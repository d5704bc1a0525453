"""What can be asked of the processes of a run and done to them, by verbs, chaos and others."""

from plant.faults import FaultError
from runtime.errors import RunError
from runtime.spawning.local import ProcessGroup
from runtime.wire import topics
from runtime.wire.bus import Bus

_ANSWER = 1.0  # [s] to wait for the answer to a request


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

    def fault(self, text: str) -> str:
        """Ask the plant for a fault, such as `joint/1:locked`, and return its answer.

        `RunError` if no plant answers, `FaultError` if it has no such fault.
        """
        answers = self._bus.ask(topics.FAULT, text.encode(), self._timeout)
        if not answers:
            raise RunError("no plant answers")
        said = answers[0].data.decode(errors="replace")
        if not answers[0].agreed:
            raise FaultError(said)
        return said
