"""Real processes on ports of their own, of which none is left when the test is over."""

import json
import os
import random
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest

from runtime.config.deployment import load
from runtime.results.evaluation import errors
from runtime.results.logs import read_log
from runtime.results.run_log import read_run_log
from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.mesh import Mesh, on_loopback, port_base
from runtime.wire.messages import Diag
from runtime.wire.packing import unpack
from tests.ports import reserve_any, reserve_free

ROOT = Path(__file__).parents[2]
signal.signal(signal.SIGINT, signal.default_int_handler)
# A shell that has pytest in the background ignores it, and all that is started here would too.
T = TypeVar("T")
CLOSE = 0.003
"""Largest error of a hand that follows its goal, where all its agents answer in time [m]."""
FOLLOWS = 0.05
"""The same where a busy machine lets them answer several periods late [m]."""
GOES = 0.073
"""Speed of the goal of Table 1 [m/s]."""
TOLERANCE = 0.05
"""Error at the end of a run that counts as having reached the goal [m], for the same reason."""
SOON = 15.0
"""Within which happens on a busy machine what takes less than a second on an idle one [s]."""
DEADLINE = 60.0
"""For anything that is waited for, however busy the machine is [s]."""
RUN_DEADLINE = 120.0
"""For a run of up to 24 s to end, however busy the machine is [s]."""


def wait_for(look: Callable[[], T | None], what: str, timeout: float = DEADLINE) -> T:
    """Return what `look` finds, as soon as it finds it; fail after `timeout` [s]."""
    until = time.monotonic() + timeout
    while time.monotonic() < until:
        found = look()
        if found:
            return found
        time.sleep(0.02)
    raise AssertionError(f"waited {timeout:g} s in vain for {what}")


class ProcessGroup:
    """The processes of one robot: each started as a person would, by `msma agent`."""

    def __init__(self, folder: Path, robot: str, port: int, stack: ExitStack) -> None:
        self.robot, self.port, self.run = robot, port, folder / "run"
        self.file = ROOT / "deploy" / "arph.yaml"
        self.options = ["--set", "patience=20s", "--scheduling", "normal"]
        self._stack = stack
        self.all: dict[str, subprocess.Popen[str]] = {}

    def start(self, *roles: str, more: tuple[str, ...] = ("--run", "")) -> None:
        """Start a process for each role; without `more` they log to the folder of the test."""
        more = ("--run", str(self.run)) if more == ("--run", "") else more
        for role in roles:
            command = ["agent", str(self.file), role, "--robot", self.robot, *self.options, *more]
            command += ["--set", f"port={self.port}"]
            process = subprocess.Popen(
                [sys.executable, "-c", "from runtime.cli import msma; msma()", *command],
                cwd=ROOT,
                stderr=subprocess.PIPE,
                text=True,
            )
            self._stack.callback(_end, process)
            self.all[role] = process

    def kill(self, role: str, number: int = signal.SIGKILL) -> None:
        """Send a signal to the process that was started last in that role."""
        self.all[role].send_signal(number)

    def result(self, role: str, timeout: float = DEADLINE) -> tuple[int, str]:
        """Wait for the end of a process: its exit code, and what it said."""
        said = self.all[role].communicate(timeout=timeout)[1]
        return self.all[role].returncode, said

    def visit(self) -> Bus:
        """Join the bus as a tool does."""
        place = on_loopback(self.port, 16).visitor()
        return self._stack.enter_context(Bus(self.robot, "a test", place, random.getrandbits(60)))

    def diag(self, bus: Bus, role: str) -> Diag | None:
        """Ask a role how it is."""
        answers = bus.ask(topics.diag(role), timeout=1.0)
        return unpack(Diag, answers[0].data) if answers else None

    def until(self, bus: Bus, role: str, true: Callable[[Diag], bool], what: str) -> Diag:
        """Wait until something is true of what a role says of itself."""

        def look() -> Diag | None:
            diag = self.diag(bus, role)
            return diag if diag is not None and true(diag) else None

        return wait_for(look, f"{role}: {what}")


def _command(arguments: Sequence[str]) -> list[str]:
    """Return the command line of `msma`: what is launched has `TOLERANCE` if no other is given.

    It has normal priority likewise, or as root the robots of several tests at once would leave
    nothing to other tests' browsers and tools; but for a rehearsal, whose hosts share this machine.
    """
    more: tuple[str, ...] = ()
    if arguments[0] in ("launch", "chaos"):
        if "tolerance=" not in " ".join(arguments):
            more += ("--set", f"tolerance={TOLERANCE} m")
        if not {"--scheduling", "--rehearse"} & set(arguments):
            more += ("--scheduling", "normal")
    return [sys.executable, "-m", "runtime.cli", *arguments, *more]


class Robot:
    """A robot of a name of its own, with `msma` as a person would use it from another folder.

    As for one who has not installed matplotlib, its runs end without a plot: each would take half
    as much processor time again as a run of a second.
    """

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self.name = free_name(stack)
        self.folder = folder / self.name
        self.folder.mkdir()
        missing = folder / "missing"
        missing.mkdir(exist_ok=True)
        (missing / "matplotlib.py").write_text("raise ImportError")
        self.environment = {**os.environ, "PYTHONPATH": f"{missing}{os.pathsep}{ROOT}"}
        self._started: list[subprocess.Popen[str]] = []
        stack.callback(self._end)

    def msma(self, *arguments: str, **more: Any) -> subprocess.CompletedProcess[str]:
        """Call `msma` and wait for its end."""
        return subprocess.run(
            _command(arguments),
            cwd=self.folder,
            env=self.environment,
            capture_output=True,
            text=True,
            timeout=RUN_DEADLINE,
            **more,
        )

    def tool(self, verb: str, *arguments: str) -> subprocess.CompletedProcess[str]:
        """Call a verb for this robot."""
        return self.msma(verb, *arguments, "--robot", self.name)

    def working(self, verb: str, *arguments: str, says: str = "") -> str:
        """Call a verb until it works: on a busy machine who is asked may answer too late.

        Args:
            verb: Verb.
            arguments: Its arguments; without a file among them it is told the robot's name too.
            says: What it is to say.

        Returns:
            What it said.
        """

        call = self.msma if "--file" in arguments else self.tool

        def works() -> str:
            done = call(verb, *arguments)
            came_late = verb == "revive" and "is alive" in done.stderr
            if (done.returncode == 0 and says in done.stdout) or came_late:
                return done.stdout or "\n"
            print(verb, *arguments, done.stdout, done.stderr)  # shown if it never works
            return ""

        return wait_for(works, f"msma {verb} to work")

    def launch(self, *options: str, file: str = "arph.yaml") -> subprocess.Popen[str]:
        """Start `msma launch` for this robot."""
        return self.start("launch", str(ROOT / "deploy" / file), "--robot", self.name, *options)

    def start(self, *arguments: str) -> subprocess.Popen[str]:
        """Start `msma` and do not wait for its end."""
        process = subprocess.Popen(
            _command(arguments),
            cwd=self.folder,
            env=self.environment,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )
        self._started.append(process)
        return process

    def run(self, *options: str, file: str = "arph.yaml") -> tuple[int, str]:
        """Launch and wait for the end: the exit code, and all that was said."""
        launcher = self.launch(*options, file=file)
        out, err = launcher.communicate(timeout=RUN_DEADLINE)
        return launcher.returncode, out + err

    def run_in_time(self, speed: float, *options: str, file: str = "arph.yaml") -> tuple[int, str]:
        """Do so at a speed, or `slower`."""
        for share in slower(self):
            code, said = self.run("--speed", f"{share * speed:g}", *options, file=file)
            if code == 0:
                break
        return code, said

    @property
    def run_folder(self) -> Path:
        """The folder of its last run."""
        return max((self.folder / "runs").iterdir(), key=lambda folder: folder.stat().st_mtime)

    @property
    def mesh(self) -> Mesh:
        """The addresses and ports of its last run: others than usual if something had those."""
        return load(self.run_folder / "deployment.yaml").mesh

    @property
    def is_in_time(self) -> bool:
        """Whether all commands of its last run came in time."""
        return came_in_time(self.run_folder)

    @property
    def follows(self) -> float:
        """How closely the hand has to follow in its last run [m].

        While agents are silent what they move stands still, and the goal of Table 1 goes on.
        """
        if self.is_in_time:
            return CLOSE
        record = read_run_log(self.run_folder)
        period: float = load(self.run_folder / "deployment.yaml").period
        silent = np.isnan(record.age[record.t >= 0.5]).any(axis=1).sum() * period
        return FOLLOWS + GOES * float(silent)

    @property
    def error_at_the_end(self) -> float:
        """The least error of the hand in the last second of its last run [m].

        At any one tick it may be late, on a busy machine.
        """
        path = load(self.run_folder / "deployment.yaml").goal
        assert path is not None
        log = read_run_log(self.run_folder)
        return float(errors(log, path.build())[log.t > log.t[-1] - 1.0, 0].min())

    @property
    def summary(self) -> dict[str, Any]:
        """What its last run's summary says."""
        found: dict[str, Any] = json.loads((self.run_folder / "summary.json").read_text())
        return found

    def log(self, role: str, event: str) -> list[dict[str, Any]]:
        """Return the lines of an event in a role's log."""
        lines = read_log(self.run_folder, role)
        return [line for line in lines if line["event"] == event]

    @property
    def t(self) -> float:
        """Plant time that the log has reached [s]; negative while there is none."""
        with suppress(OSError, ValueError, IndexError):
            return float(self.log("plant", "tick")[-1]["t"])
        return -1.0

    def until(self, t: float) -> None:
        """Wait for a plant time [s]."""
        wait_for(lambda: self.t >= t, f"plant time {t:g} s")

    def pid(self, role: str) -> int:
        """Return the process id of the last one started in a role, once its log says so."""
        started = wait_for(lambda: self.log(role, "start"), f"the start of {role} in its log")
        return int(started[-1]["pid"])

    def processes(self) -> dict[int, str]:
        """Return all processes that this robot's launchers and tools have left running."""
        found = {}
        for folder in Path("/proc").glob("[0-9]*"):
            with suppress(OSError):
                if (folder / "cwd").readlink() == self.folder:  # all begin in it and stay
                    found[int(folder.name)] = (folder / "cmdline").read_text().rstrip("\0")
        for process in self._started:
            found.pop(process.pid, None)
        return found

    def _end(self) -> None:
        for process in self._started:
            process.kill()
            process.communicate()
        for pid in self.processes():
            with suppress(ProcessLookupError):
                os.kill(pid, signal.SIGKILL)
        wait_for(lambda: not self.processes(), "all processes to be gone")


def slower(*robots: Robot) -> Iterator[float]:
    """Yield shares of a speed to run robots at, while a busy machine was too slow for the last."""
    for share in (1.0, 0.5, 0.25):
        yield share
        if all(robot.is_in_time for robot in robots):
            return


def came_in_time(run: Path) -> bool:
    """Tell whether all commands of a run came in time, by its folder."""
    record = read_run_log(run)
    period: float = load(run / "deployment.yaml").period
    return bool((record.age[record.t >= 0.5] < 2 * period).all())


def free_name(stack: ExitStack) -> str:
    """Return a robot's name whose ports are free, and stay so until the stack is closed."""
    while True:
        name = f"test-{os.getpid()}-{random.randrange(10**6)}"
        reservation = reserve_free(port_base(name))
        if reservation is not None:
            stack.enter_context(reservation)
            return name


@pytest.fixture
def make_robot(tmp_path: Path) -> Iterator[Callable[[], Robot]]:
    """Make robots to launch."""
    with ExitStack() as stack:
        yield lambda: Robot(tmp_path, stack)


@pytest.fixture
def robot(make_robot: Callable[[], Robot]) -> Robot:
    """Make one robot to launch."""
    return make_robot()


def _end(process: subprocess.Popen[str]) -> None:
    """Leave nothing behind, not even what is stopped."""
    process.kill()
    process.communicate()
    with suppress(ProcessLookupError):
        os.kill(process.pid, 0)
        raise AssertionError(f"process {process.pid} is still there")


@pytest.fixture
def make_processes(tmp_path: Path) -> Iterator[Callable[[], ProcessGroup]]:
    """Make groups of processes, each of a robot of its own."""
    with ExitStack() as stack:

        def make() -> ProcessGroup:
            port, reservation = reserve_any()
            stack.enter_context(reservation)
            folder = tmp_path / str(port)
            folder.mkdir()
            robot = f"test-{os.getpid()}-{port}"
            while port_base(robot) == port:  # which it would leave for others if they are taken
                robot += "x"
            return ProcessGroup(folder, robot, port, stack)

        yield make


@pytest.fixture
def processes(make_processes: Callable[[], ProcessGroup]) -> ProcessGroup:
    """The processes of one robot."""
    return make_processes()
