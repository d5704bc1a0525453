"""Starting the process of a role again, in the run that goes on."""

import time
from pathlib import Path

from runtime.errors import RunError
from runtime.results.logs import read_log
from runtime.spawning.forkserver import ForkServer
from runtime.spawning.tasks import Task
from runtime.watching.discovery import Target, visit
from runtime.watching.local import diags, run_of
from runtime.wire.bus import Bus

_PATIENCE = 10.0  # [s] for it to be seen alive


def revive(role: str, target: Target, forkserver: ForkServer) -> int:
    """Start a robot's role again, wait until it is seen alive, and return the process's id.

    Raises `RunError` if it is alive or does not come, `ConfigError` if the run has no such role.
    """
    began = time.monotonic()
    with visit(target) as bus:
        told = diags(bus)
        if any(diag.role == role for diag in told):
            raise RunError(f"{role} is alive; `msma agent --copy` starts another beside it")
        task = _task(Path(run_of(told).run), role)
        child = forkserver.start(task)
        while not _is_alive(bus, role, child.pid):
            if child.poll() is not None:
                raise RunError(f"{role} did not start: {task.said}")
            if time.monotonic() - began > _PATIENCE:
                raise RunError(f"{role}, process {child.pid}, is not seen alive")
            time.sleep(0.02)
    return child.pid


def _task(run: Path, role: str) -> Task:
    task = Task(role, run)
    if not task.file.is_file():
        raise RunError(f"there is no {task.file}: start it with `msma agent FILE {role}`")
    if not read_log(run, role, "start"):  # it never had
        from runtime.config.deployment import load

        load(task.file, only_role=role)
    return task


def _is_alive(bus: Bus, role: str, pid: int) -> bool:
    return any(diag.pid == pid for diag in diags(bus, role))
