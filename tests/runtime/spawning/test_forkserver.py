"""Processes that begin as copies of one that waits for it."""

import os
import signal
import threading
from collections.abc import Iterator
from pathlib import Path

import psutil
import pytest

from runtime.config.deployment import ProcessSpec
from runtime.spawning import forkserver as nurseries
from runtime.spawning.forkserver import ChildProcess, ForkServer
from runtime.spawning.local import LocalProcesses
from runtime.spawning.tasks import LOST, Task
from tests.runtime.conftest import wait_for


@pytest.fixture
def forkserver(monkeypatch: pytest.MonkeyPatch) -> Iterator[ForkServer]:
    """A forkserver, though pytest may have threads by now: the copies do without them."""
    monkeypatch.setattr(nurseries, "_can_be_copied", lambda: True)
    with ForkServer() as forkserver:
        yield forkserver


def task(run: Path) -> Task:
    """What ends at once with exit code 2, since there is no such file."""
    return Task("joint/1", run)


def ended(child: ChildProcess) -> int:
    wait_for(lambda: child.poll() is not None, "its end")
    code = child.poll()
    assert code is not None
    return code


def parent_of(pid: int) -> int:
    return int(Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[1])


def test_a_copy_does_its_task_and_says_how_it_ended(forkserver: ForkServer, tmp_path: Path) -> None:
    child = forkserver.start(task(tmp_path))
    assert parent_of(child.pid) != os.getpid()
    assert ended(child) == 2
    assert child.poll() == 2


def test_an_id_stays_its_own_until_its_end_was_heard_of(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    child = forkserver.start(task(tmp_path))
    wait_for(lambda: " Z " in Path(f"/proc/{child.pid}/stat").read_text(), "it to end")
    os.kill(child.pid, signal.SIGKILL)  # nobody else's
    assert child.poll() == 2
    assert not Path(f"/proc/{child.pid}").exists()


def test_nothing_is_started_that_could_not_say_why_it_fails(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    with pytest.raises(FileNotFoundError, match=r"joint-1\.out"):
        forkserver.start(task(tmp_path / "nowhere"))


def test_if_one_cannot_be_started_those_before_it_are_not_forgotten(tmp_path: Path) -> None:
    (tmp_path / "joint-2.out").symlink_to(tmp_path / "nowhere" / "joint-2.out")
    children = LocalProcesses(tmp_path)
    with pytest.raises(OSError, match=r"joint-2\.out"):
        children.start(ProcessSpec(f"joint/{number}", "here") for number in (1, 2, 3))
    assert len(children) == 1
    (first,) = wait_for(children.ended, "the end of the first")
    assert (first.role, first.code) == ("joint/1", 2)
    children.tidy()


def test_who_is_killed_ends_by_that_signal(forkserver: ForkServer, tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "deployment.yaml")  # it waits for who writes into it
    child = forkserver.start(task(tmp_path))
    assert child.poll() is None
    os.kill(child.pid, signal.SIGKILL)
    assert ended(child) == -signal.SIGKILL


def test_without_its_nursery_a_process_goes_on_and_others_run_python_anew(
    forkserver: ForkServer, tmp_path: Path
) -> None:
    os.mkfifo(tmp_path / "deployment.yaml")
    orphan = forkserver.start(task(tmp_path))
    os.kill(parent_of(orphan.pid), signal.SIGKILL)
    other = forkserver.start(Task("joint/2", tmp_path))
    assert parent_of(other.pid) == os.getpid()
    for child, code in ((orphan, LOST), (other, -signal.SIGKILL)):
        assert child.poll() is None
        os.kill(child.pid, signal.SIGKILL)
        assert ended(child) == code


def test_a_nursery_ends_with_whoever_made_it(tmp_path: Path) -> None:
    pid = os.fork()
    if pid == 0:
        child = ForkServer().start(task(tmp_path))
        (tmp_path / "forkserver").write_text(f"{parent_of(child.pid)}")
        os.kill(os.getpid(), signal.SIGKILL)
    os.waitpid(pid, 0)
    forkserver = int((tmp_path / "forkserver").read_text())
    assert forkserver != pid
    wait_for(lambda: not psutil.pid_exists(forkserver), "the forkserver to end")


def test_a_process_of_several_threads_runs_python_anew(tmp_path: Path) -> None:
    released = threading.Event()
    thread = threading.Thread(target=released.wait)
    thread.start()
    try:
        with ForkServer() as forkserver:
            child = forkserver.start(task(tmp_path))
            assert parent_of(child.pid) == os.getpid()
            assert ended(child) == 2
    finally:
        released.set()
        thread.join()
