"""Starting the process of a role again, in the run that goes on."""

import time
from pathlib import Path

from runtime.launching.failures import RunError
from runtime.launching.finding import Target, visit
from runtime.launching.local import diags, run_of
from runtime.launching.logs import read_log
from runtime.launching.nursery import Nursery
from runtime.launching.starting import Task
from runtime.wire.bus import Bus

_PATIENCE = 10.0  # [s] for it to be seen alive


def revive(role: str, target: Target, nursery: Nursery) -> int:
    """Start a robot's role again, wait until it is seen alive, and return the process's id.

    Raises `RunError` if it is alive or does not come, `ConfigError` if the run has no such role.
    """
    began = time.monotonic()
    with visit(target) as bus:
        told = diags(bus)
        if any(diag.role == role for diag in told):
            raise RunError(f"{role} is alive; `msma agent --copy` starts another beside it")
        task = _task(Path(run_of(told).run), role)
        child = nursery.start(task)
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
