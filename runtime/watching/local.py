"""The processes of a robot that runs: what they answer, which run here, and reviving one."""

import os
import time

from runtime.errors import RunError
from runtime.results.logs import read_log
from runtime.spawning.forkserver import ForkServer
from runtime.spawning.identity import ProcessId, processes_in
from runtime.spawning.local import LocalProcesses
from runtime.watching.discovery import Target, visit
from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.messages import Diag
from runtime.wire.packing import unpack_valid

_ANSWER = 1.0  # [s]
_AGAIN = 0.02  # [s] before a process is asked again
_START = 10.0  # [s] for a revived process to be seen alive
_HANGS = 1.0  # [s] without an answer after which a process that is there is said to hang


def diags(bus: Bus, role: str = "**") -> list[Diag]:
    """Query the diagnostics of a role, or of all; return those that answer."""
    answers = bus.ask(topics.diag(role), timeout=_ANSWER)
    return [diag for one in answers if (diag := unpack_valid(Diag, one.data))]


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


def silent_roles(bus: Bus, target: Target) -> dict[str, str]:
    """Return the roles of the run here that say nothing, and why, as far as is known."""
    from runtime.config.deployment import load  # most of what a tool imports, if it does

    answering, silent = {diag.role for diag in diags(bus)}, {}
    for run in target.runs[:1]:
        for role in load(run / "deployment.yaml", only_role=topics.PLANT).roles:
            if role not in answering:
                silent[role] = "is not there"
                if there := processes_in(target.run_with(role), role):
                    silent[role] = f"does not answer, process {there[-1].pid}"
    return silent


def _answers(bus: Bus, role: str, target: Target) -> bool:
    """Return whether a role answers, which takes a busy process of this machine a while."""
    until = time.monotonic() + _HANGS
    while not diags(bus, role):
        if not processes_in(target.run_with(role), role) or time.monotonic() > until:
            return False
        time.sleep(_AGAIN)
    return True


def revive(role: str, target: Target, forkserver: ForkServer) -> int:
    """Start a robot's role again, wait until it is seen alive, and return the process's id.

    `RunError` if it is alive, or does not come, or its run is not one that this user has started;
    `ConfigError` if the run has no such role.
    """
    began = time.monotonic()
    with visit(target) as bus:
        if _answers(bus, role, target):
            raise RunError(f"{role} is alive; `msma agent --copy` starts another beside it")
        run = target.run_with(role)
        host = ""  # which only a copy beside a process that hangs has to know
        if processes_in(run, role) or not read_log(run, role, "start"):
            from runtime.config.deployment import load  # most of what a tool imports, if it does

            host = load(run / "deployment.yaml", only_role=role).host_of(role)
        processes = LocalProcesses(run, forkserver)
        pid = processes.revive(role, host)
        while not any(diag.pid == pid for diag in diags(bus, role)):
            for ended in processes.ended():
                raise RunError(f"{role} did not start: {ended.said}")
            if time.monotonic() - began > _START:
                raise RunError(f"{role}, process {pid}, is not seen alive")
            time.sleep(_AGAIN)
    return pid
