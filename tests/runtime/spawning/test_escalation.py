"""Histories of a clock: what is tried when, and that all processes have ended at last."""

import os
import signal
from collections.abc import Iterable
from pathlib import Path
from signal import Signals

import pytest

from runtime.config.deployment import ProcessSpec
from runtime.spawning.escalation import ALL_MEANS, FORCE, Escalation, Means, end_all
from runtime.spawning.local import LocalProcesses, ProcessExit
from tests.runtime.conftest import wait_for


@pytest.mark.parametrize(
    ("clock", "means"),
    [
        ([9.9], [[]]),
        ([10.0, 10.5, 11.0, 11.9, 12.0, 99.0], [[0], [], [1], [], [2], []]),
        ([10.0, 99.0], [[0], [1, 2]]),
    ],
    ids=["not yet", "one after another", "after a hang"],
)
def test_the_steps_are_due_one_after_another(clock: list[float], means: list[list[int]]) -> None:
    escalation = Escalation(10.0, pause=1.0)
    assert [escalation.due(now) for now in clock] == [[ALL_MEANS[i] for i in m] for m in means]


def test_force_does_not_ask() -> None:
    assert Escalation(0.0, FORCE, pause=0.0).due(0.0) == [Means.TERMINATE, Means.KILL]


class Unwilling:
    """A group of one process, which ends at the last signal; some steps raise an error."""

    def __init__(self, *errors: Exception) -> None:
        self.errors = list(errors)
        self.got: list[Signals] = []

    def signal(self, number: Signals) -> None:
        self.got.append(number)
        if self.errors:
            raise self.errors.pop(0)

    def ended(self) -> list[ProcessExit]:
        return []

    def __len__(self) -> int:
        return int(signal.SIGKILL not in self.got)

    def start(self, processes: Iterable[ProcessSpec]) -> None: ...

    def revive(self, role: str, home: str) -> int:
        return 0

    def obeyed(self, role: str) -> list[int]:
        return []

    def send(self, role: str, pid: int, number: Signals) -> None: ...

    def tidy(self) -> None: ...


def test_a_step_that_fails_does_not_keep_the_next_from_being_tried() -> None:
    def ask() -> None:
        raise ConnectionError("the bus is closed")

    group = Unwilling(ProcessLookupError())
    end_all(group, Escalation(0.0, pause=0.0), ask=ask)
    assert group.got == [signal.SIGTERM, signal.SIGKILL]


def test_an_error_of_ours_is_raised_once_all_processes_have_ended() -> None:
    group = Unwilling(ValueError("list.remove(x): x not in list"))
    with pytest.raises(ValueError, match="not in list"):
        end_all(group, Escalation(0.0, pause=0.0))
    assert group.got == [signal.SIGTERM, signal.SIGKILL]


def test_all_are_ended_though_the_forkserver_and_one_of_them_are_gone(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("runtime.spawning.forkserver._can_be_copied", lambda: True)
    os.mkfifo(tmp_path / "deployment.yaml")  # each waits for who writes into it
    children = LocalProcesses(tmp_path)
    children.start([ProcessSpec("joint/1", "here"), ProcessSpec("joint/2", "here")])
    (first,), (second,) = children.pids("joint/1"), children.pids("joint/2")
    forkserver = int(Path(f"/proc/{first}/stat").read_text().rpartition(")")[2].split()[1])
    assert forkserver != os.getpid()
    os.kill(forkserver, signal.SIGKILL)
    os.kill(first, signal.SIGKILL)  # nobody keeps its id until its end was asked for
    wait_for(lambda: not Path(f"/proc/{first}").exists(), "its end")
    exits: list[ProcessExit] = []
    end_all(children, Escalation(0.0, FORCE, pause=0.2), ended=exits.append)
    children.tidy()
    assert {one.pid for one in exits} == {first, second}
