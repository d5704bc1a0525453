"""The runs that this user has started on this machine, by robot: a private folder of small files.

Tools look a run up here. What any process says on the bus of where its files are is not trusted:
another user may have put a process there.
"""

import fcntl
import os
import pwd
import tempfile
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Self
from zlib import crc32

import msgspec

from runtime.atomic import write_atomically
from runtime.errors import RunError
from runtime.processes.log_writer import new_run_folder
from runtime.spawning.identity import ProcessId, processes_in
from runtime.spawning.ports import block_of, is_taken
from runtime.spawning.trust import distrust, distrust_modules
from runtime.wire.mesh import SLOTS
from runtime.wire.topics import role_of_file

if TYPE_CHECKING:
    from runtime.config.deployment import Deployment  # tools that need not read one start sooner


class RegisteredRun(msgspec.Struct, frozen=True):
    """A run that this user has started.

    Attributes:
        folder: The run's folder, with the deployment as resolved, and the logs.
        port: The first of the robot's ports.
        modules: The folder of the classes that the deployment may name.
        plain: Whether it is all on this machine and asks for no certificates, so that a tool needs
            to know no more than the port.
        process: What has started it: a launcher, or a process that was started by hand.
    """

    robot: str
    folder: Path
    port: int
    modules: Path
    plain: bool
    process: ProcessId

    @classmethod
    def of(cls, deployment: "Deployment", folder: Path) -> Self:
        """Return that of a run which this process starts."""
        real, modules = (Path(os.path.realpath(path)) for path in (folder, deployment.modules))
        plain = deployment.all_here and deployment.security is None
        return cls(deployment.robot, real, deployment.port, modules, plain, ProcessId.own())

    @property
    def deployment(self) -> Path:
        """The file of the deployment as resolved."""
        return self.folder / "deployment.yaml"

    def lives(self) -> bool:
        """Tell whether what has started it lives, or else any process of it."""
        if self.process.lives():
            return True
        logs = sorted(self.folder.glob("*.jsonl"), key=lambda log: log.stat().st_size)
        return any(processes_in(self.folder, role_of_file(log.stem)) for log in logs)

    def distrust(self) -> str | None:
        """Return why another user may have changed its files, None if none can."""
        return distrust(self.deployment) or distrust_modules(self.modules)


def registry() -> Path:
    """Return the private folder; `RunError` if there can be none."""
    why = ""
    for folder in _candidates():
        try:
            folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        except OSError as error:
            why = f"{folder}: {error.strerror}"
            continue
        real = Path(os.path.realpath(folder))
        if not (why := distrust(real) or ""):
            return real
    raise RunError(f"there is no private folder to note what runs: {why}")


def _candidates() -> Iterator[Path]:
    """Yield where it may be: by the user alone, not by what the environment says (as with sudo)."""
    with suppress(KeyError):
        yield Path(pwd.getpwuid(os.geteuid()).pw_dir) / ".cache" / "msma" / "runs"
    yield Path(tempfile.gettempdir()) / f"msma-{os.geteuid()}"


def runs_of(robot: str = "*", port: int | str = "*") -> list[RegisteredRun]:
    """Return the runs of a robot, or at a port, that go on and are to be trusted; newest first.

    Those that have ended are forgotten.
    """
    return [run for run in _all_runs(robot, port) if run.distrust() is None]


def why_not(robot: str) -> str:
    """Return why none of a robot's runs can be trusted, for people."""
    for run in _all_runs(robot):
        if why := run.distrust():
            return f"{why}, so {run.deployment} is not trusted"
    return f"this user has started no run of {robot} here"


def _all_runs(robot: str, port: int | str = "*") -> list[RegisteredRun]:
    found = []
    decode = msgspec.json.Decoder(RegisteredRun, dec_hook=lambda _, text: Path(text)).decode
    for file in _files(robot, port):
        run = None
        with suppress(OSError, ValueError):
            run = decode(file.read_bytes())
        if run and run.deployment.exists() and (run.distrust() or run.lives()):
            found.append(run)
        else:
            file.unlink(missing_ok=True)
    return sorted(found, key=lambda run: run.process.started, reverse=True)


def _files(robot: str, port: int | str, folder: Path | None = None) -> list[Path]:
    """Return the files of runs; those of a run's folder are the ones that this process made."""
    which = "*" if folder is None else _identity(folder)
    try:
        return list(registry().glob(f"{robot}.{port}.{which}.json"))
    except (OSError, RunError):
        return []


def _identity(folder: Path) -> str:
    return f"{crc32(bytes(folder)):08x}-{os.getpid()}"


def register(run: RegisteredRun) -> None:
    """Note a run; if that cannot be, tools find it by its file only."""
    with suppress(OSError, RunError):
        file = registry() / f"{run.robot}.{run.port}.{_identity(run.folder)}.json"
        text = msgspec.json.encode(run, enc_hook=str)
        write_atomically(file, lambda new: new.write_bytes(text))


def forget(robot: str, folder: Path) -> None:
    """Take back what this process has noted of a run."""
    for file in _files(robot, "*", Path(os.path.realpath(folder))):
        file.unlink(missing_ok=True)


@contextmanager
def _alone() -> Iterator[None]:
    """Keep other processes of this user from choosing ports meanwhile."""
    with ExitStack() as stack:
        with suppress(OSError, RunError):
            lock = stack.enter_context((registry() / "lock").open("w"))
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def begin_run(deployment: "Deployment") -> "tuple[Deployment, Path]":
    """Make the folder of a new run, and return it with the deployment as resolved, also in it."""
    with _alone():
        return _enter(_with_ports(deployment), None)


def join_run(deployment: "Deployment", folder: Path | None = None) -> "tuple[Deployment, Path]":
    """Return the run that a process started by hand belongs to, and its deployment as resolved.

    It is the one in that folder, or else the robot's newest that goes on here, or a new one. The
    ports of a run are those in its folder, also where nobody has noted it and its own plant has
    them already.
    """
    port = _port_in(folder) if folder else None
    with _alone():
        deployment = replace(deployment, port=port) if port else _with_ports(deployment)
        same = (run.folder for run in runs_of(deployment.robot) if run.port == deployment.port)
        return _enter(deployment, folder or next(same, None))


def _port_in(folder: Path) -> int | None:
    """Return the first port of the run in a folder, None if there is none yet.

    Nothing else is read: this host may lack the classes of other roles.
    """
    from runtime.config.deployment import Port
    from runtime.config.reading import kind_of
    from runtime.config.tree import read_file

    file = folder / "deployment.yaml"
    node = read_file(file).children.get("port") if file.exists() else None
    port: int | None = None if node is None else kind_of(Port).read(node, {})
    return port


def _enter(deployment: "Deployment", folder: Path | None) -> "tuple[Deployment, Path]":
    try:
        folder = (folder or new_run_folder(deployment.runs, deployment.robot)).absolute()
        folder.mkdir(parents=True, exist_ok=True)
        if not (file := folder / "deployment.yaml").exists():
            write_atomically(file, lambda new: new.write_text(deployment.dump(), encoding="utf-8"))
    except OSError as error:
        why = error.strerror or error
        raise RunError(f"the folder of the run cannot be written: {why}") from None
    register(RegisteredRun.of(deployment, folder))
    return deployment, folder


def _with_ports(deployment: "Deployment") -> "Deployment":
    """Return a deployment with the ports that its robot has or takes on this machine.

    It takes the next that are free if another robot has its usual ones. A port that its file sets
    stays, and so does one that other hosts have to know.
    """
    robot, port = deployment.robot, deployment.port
    if deployment.has_usual_ports:
        known = [run.port for run in runs_of(robot)]
        port = known[0] if known else block_of(robot, port, _is_free)
    return replace(deployment, port=port)


def _is_free(base: int) -> bool:
    return not runs_of(port=base) and not any(map(is_taken, range(base, base + SLOTS)))
