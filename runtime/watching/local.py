"""The processes of a robot that run on this host, by their ids."""

import socket
from pathlib import Path

from runtime.errors import RunError
from runtime.results.logs import read_log
from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.messages import Diag, unpack
from runtime.wire.refusals import MessageError

_PATIENCE = 1.0  # [s]


def diags(bus: Bus, role: str = "**") -> list[Diag]:
    """Ask a role, or all, how they are; return what those say who answer."""
    found = []
    for answer in bus.ask(topics.diag(role), timeout=_PATIENCE):
        try:
            found.append(unpack(Diag, answer.data))
        except MessageError:
            continue
    return found


def run_of(told: list[Diag]) -> Diag:
    """Return what the plant says of the run, or else anybody; `RunError` if nobody does."""
    if not told:
        raise RunError("nobody there says which run this is: all processes hang")
    return min(told, key=lambda diag: diag.role != topics.PLANT)


def pid_in(bus: Bus, role: str) -> int:
    """Return the id of a role's process on this host; `RunError` if there is none.

    Of copies it is the one whom the plant obeys. One that hangs does not say its id: it is then
    the last that was started, by the run's log.
    """
    told = diags(bus)
    own = [diag for diag in told if diag.role == role]
    hosts = {diag.host for diag in own}
    if hosts and socket.gethostname() not in hosts:
        raise RunError(f"{role} runs on {', '.join(sorted(hosts))}: go there for that")
    here = [diag.pid for diag in own if diag.host == socket.gethostname()]
    run = Path(run_of(told).run)
    obeyed = obeyed_in(run, role)
    if obeyed is None:
        obeyed = next((pid for pid in here if _is_in(pid, role)), None)
    if obeyed is None:
        raise RunError(f"no process of {role} runs here")
    return obeyed


def obeyed_in(run: Path, role: str) -> int | None:
    """Return the id of a role's process in a run on this host, None if none is here.

    Of copies it is the one whom the plant obeys, by its log, or else the one started last.
    """
    pids = logged(run, role)
    if len(pids) > 1:
        starts = {line.get("by"): line["pid"] for line in read_log(run, role, "start")}
        for line in reversed(read_log(run, topics.PLANT, "obeys")):
            if line["role"] == role:
                pid = starts.get(line["by"])
                return pid if pid in pids else pids[-1]
    return pids[-1] if pids else None


def watchers(robot: str) -> list[int]:
    """Return the ids of each `msma status --watch` of a robot on this host."""
    wanted = f"status --watch --robot {robot}".split()
    found = []
    for folder in Path("/proc").glob("[0-9]*"):
        if _arguments(int(folder.name))[1:5] == wanted:
            found.append(int(folder.name))
    return found


def silent_roles(told: list[Diag]) -> dict[str, str]:
    """Return the roles that belong to a run and say nothing, and why, as far as is known here."""
    if not told or not (file := Path(run_of(told).run) / "deployment.yaml").is_file():
        return {}
    from runtime.config.deployment import load  # most of what a tool imports, if it does

    silent = {}
    for role in load(file, only_role=topics.PLANT).roles:
        if not any(diag.role == role for diag in told):
            pids = logged(file.parent, role)
            silent[role] = f"hangs, process {pids[-1]}" if pids else "is not there"
    return silent


def logged(run: Path, role: str) -> list[int]:
    """Return the ids of a role's processes in a run that live on this host, the newest last."""
    return [line["pid"] for line in read_log(run, role, "start") if _is_in(line["pid"], role)]


def _is_in(pid: int, role: str) -> bool:
    """Tell whether a process id still is that of a process in a role."""
    arguments = _arguments(pid)
    return "agent" in arguments and role in arguments


def _arguments(pid: int) -> list[str]:
    """Return what a process was called with, or calls itself; nothing if it is not there."""
    try:
        line = Path(f"/proc/{pid}/cmdline").read_bytes()
    except OSError:
        return []
    return line.decode(errors="replace").replace("\0", " ").split()
