"""The diagnostics that the processes of a robot answer, and which of them run on this host."""

import os
import socket

from runtime.errors import RunError
from runtime.spawning.identity import ProcessId, processes_in
from runtime.watching.discovery import Target
from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.messages import Diag, unpack_valid

_ANSWER = 1.0  # [s]


def diags(bus: Bus, role: str = "**") -> list[Diag]:
    """Query the diagnostics of a role, or of all; return those that answer."""
    answers = bus.ask(topics.diag(role), timeout=_ANSWER)
    return [diag for one in answers if (diag := unpack_valid(Diag, one.data))]


def check_is_here(bus: Bus, role: str) -> None:
    """Raise `RunError` if a role runs, but on other hosts only."""
    hosts = {diag.host for diag in diags(bus, role)}
    if hosts and socket.gethostname() not in hosts:
        raise RunError(f"{role} runs on {', '.join(sorted(hosts))}: use this command there")


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
    """Return the roles of the runs here that say nothing, and why, as far as is known."""
    from runtime.config.deployment import load  # most of what a tool imports, if it does

    answering = {diag.role for diag in diags(bus)}
    silent = {}
    for run in target.runs[:1]:
        for role in load(run / "deployment.yaml", only_role=topics.PLANT).roles:
            if role not in answering:
                processes = processes_in(target.run_with(role), role)
                hangs = f"hangs, process {processes[-1].pid}" if processes else "is not there"
                silent[role] = hangs
    return silent
