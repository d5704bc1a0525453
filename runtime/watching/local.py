"""The processes of a robot that run on this host, by their ids."""

import os
import socket
from pathlib import Path

from runtime.errors import RunError
from runtime.spawning.identity import ProcessId, obeyed_in, processes_in
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


def process_in(bus: Bus, role: str) -> ProcessId:
    """Return the process of a role on this host; `RunError` if there is none.

    Of copies it is the one that the plant obeys.
    """
    told = diags(bus)
    own = [diag for diag in told if diag.role == role]
    hosts = {diag.host for diag in own}
    if hosts and socket.gethostname() not in hosts:
        raise RunError(f"{role} runs on {', '.join(sorted(hosts))}: go there for that")
    process = obeyed_in(Path(run_of(told).run), role)
    if process is None:
        raise RunError(f"no process of {role} runs here")
    return process


def watchers(robot: str) -> list[ProcessId]:
    """Return each `msma status --watch` of a robot that this user has on this host."""
    from psutil import process_iter

    found = []
    for one in process_iter(["cmdline", "uids", "create_time"]):
        title = " ".join(one.info["cmdline"] or ()).strip()
        if title == watcher_title(robot) and one.info["uids"].real == os.getuid():
            found.append(ProcessId(one.pid, one.info["create_time"]))
    return found


def watcher_title(robot: str) -> str:
    """Return what `msma status --watch` calls itself in the list of processes."""
    return f"msma status --watch --robot {robot}"


def silent_roles(told: list[Diag]) -> dict[str, str]:
    """Return the roles that belong to a run and say nothing, and why, as far as is known here."""
    if not told or not (file := Path(run_of(told).run) / "deployment.yaml").is_file():
        return {}
    from runtime.config.deployment import load  # most of what a tool imports, if it does

    silent = {}
    for role in load(file, only_role=topics.PLANT).roles:
        if not any(diag.role == role for diag in told):
            processes = processes_in(file.parent, role)
            silent[role] = f"hangs, process {processes[-1].pid}" if processes else "is not there"
    return silent
