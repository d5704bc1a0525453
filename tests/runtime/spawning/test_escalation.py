"""Histories of a clock: what is tried when, and that all processes have ended at last."""

import os
import signal
from collections.abc import Collection, Iterable
from pathlib import Path
from signal import Signals

import pytest

from runtime.config.deployment import ProcessSpec
from runtime.spawning.local import LocalProcesses, ProcessExit, end_all
from tests.runtime.conftest import wait_for


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

    def send(self, role: str, pids: Collection[int], number: Signals) -> None: ...

    def tidy(self) -> None: ...


class MadeUpTime:
    """A clock that only sleeping moves on."""

    def __init__(self) -> None:
        self.now = 10.0

    def monotonic(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> MadeUpTime:
    clock = MadeUpTime()
    monkeypatch.setattr("runtime.spawning.local.time", clock)
    return clock


@pytest.mark.parametrize(
    ("after", "hang", "times"),
    [
        (0.0, 0.0, [10.0, 11.0, 12.0]),
        (5.0, 0.0, [15.0, 16.0, 17.0]),
        (0.0, 9.0, [10.0, 19.0, 19.0]),
    ],
    ids=["at once", "after some time", "after a hang"],
)
def test_the_steps_are_tried_one_after_another(
    clock: MadeUpTime, after: float, hang: float, times: list[float]
) -> None:
    tried: list[tuple[str, float]] = []

    class Timed(Unwilling):
        def signal(self, number: Signals) -> None:
            super().signal(number)
            tried.append((number.name, clock.now))

    def ask() -> None:
        tried.append(("asked", clock.now))
        clock.now += hang

    end_all(Timed(), after=after, pause=1.0, ask=ask)
    assert [step for step, _ in tried] == ["asked", "SIGTERM", "SIGKILL"]
    assert [at for _, at in tried] == pytest.approx(times, abs=0.05)


def test_a_step_that_fails_does_not_keep_the_next_from_being_tried() -> None:
    def ask() -> None:
        raise ConnectionError("the bus is closed")

    group = Unwilling(ProcessLookupError())
    end_all(group, pause=0.0, ask=ask)
    assert group.got == [signal.SIGTERM, signal.SIGKILL]


def test_an_error_of_ours_is_raised_once_all_processes_have_ended() -> None:
    group = Unwilling(ValueError("list.remove(x): x not in list"))
    with pytest.raises(ValueError, match="not in list"):
        end_all(group, pause=0.0)
    assert group.got == [signal.SIGTERM, signal.SIGKILL]


def test_all_are_ended_though_the_forkserver_and_one_of_them_are_gone(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("runtime.spawning.forkserver._can_be_copied", lambda: True)
    os.mkfifo(tmp_path / "deployment.yaml")  # each waits for who writes into it
    children = LocalProcesses(tmp_path)
    children.start([ProcessSpec("joint/1", "here"), ProcessSpec("joint/2", "here")])
    first, second = (pid for _, pid in children.pids)
    forkserver = int(Path(f"/proc/{first}/stat").read_text().rpartition(")")[2].split()[1])
    assert forkserver != os.getpid()
    os.kill(forkserver, signal.SIGKILL)
    os.kill(first, signal.SIGKILL)  # nobody keeps its id until its end was asked for
    wait_for(lambda: not Path(f"/proc/{first}").exists(), "its end")
    exits: list[ProcessExit] = []
    end_all(children, pause=0.2, ended=exits.append)
    children.tidy()
    assert {one.pid for one in exits} == {first, second}
