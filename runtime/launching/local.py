"""The processes of a robot that run on this host, by their ids."""

import socket
from pathlib import Path

from runtime.config.deployment import load
from runtime.launching.failures import RunError
from runtime.launching.record import read_log
from runtime.wire import keys
from runtime.wire.bus import Bus
from runtime.wire.fields import MessageError
from runtime.wire.messages import Diag, unpack

_PATIENCE = 1.0  # [s]


def diags(bus: Bus, role: str = "**") -> list[Diag]:
    """Ask a role, or all, how they are; return what those say who answer."""
    found = []
    for answer in bus.ask(keys.diag(role), timeout=_PATIENCE):
        try:
            found.append(unpack(Diag, answer.data))
        except MessageError:
            continue
    return found


def run_of(told: list[Diag]) -> Diag:
    """Return what the plant says of the run, or else anybody; `RunError` if nobody does."""
    if not told:
        raise RunError("nobody there says which run this is: all processes hang")
    return min(told, key=lambda diag: diag.role != keys.PLANT)


def pids_in(bus: Bus, role: str) -> list[int]:
    """Return the ids of a role's processes on this host; `RunError` if there is none.

    One that hangs does not say its id: it is then the last that was started, by the run's log.
    """
    told = diags(bus)
    own = [diag for diag in told if diag.role == role]
    hosts = {diag.host for diag in own}
    if hosts and socket.gethostname() not in hosts:
        raise RunError(f"{role} runs on {', '.join(sorted(hosts))}: go there for that")
    pids = [diag.pid for diag in own if diag.host == socket.gethostname()]
    found = [pid for pid in pids if _is_in(pid, role)] or _logged(Path(run_of(told).run), role)
    if not found:
        raise RunError(f"no process of {role} runs here")
    return found


def silent_roles(told: list[Diag]) -> dict[str, str]:
    """Return the roles that belong to a run and say nothing, and why, as far as is known here."""
    if not told or not (file := Path(run_of(told).run) / "deployment.yaml").is_file():
        return {}
    silent = {}
    for role in load(file, only_role=keys.PLANT).roles:
        if not any(diag.role == role for diag in told):
            pids = _logged(file.parent, role)
            silent[role] = f"hangs, process {pids[0]}" if pids else "is not there"
    return silent


def _logged(run: Path, role: str) -> list[int]:
    """Return the id of the process that was started last in a role, if it lives on this host."""
    pids = [line["pid"] for line in read_log(run, role) if line["event"] == "start"]
    return [pid for pid in pids[-1:] if _is_in(pid, role)]


def _is_in(pid: int, role: str) -> bool:
    """Tell whether a process id still is that of a process in a role."""
    try:
        arguments = Path(f"/proc/{pid}/cmdline").read_bytes().replace(b"\0", b" ").split()
    except OSError:
        return False
    return b"agent" in arguments and role.encode() in arguments
