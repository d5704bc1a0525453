"""Starting the process of a role again, in the run that goes on."""

import time

from runtime.config.deployment import load
from runtime.errors import RunError
from runtime.results.logs import read_log
from runtime.spawning.forkserver import ForkServer
from runtime.spawning.tasks import Task
from runtime.watching.discovery import Target, visit
from runtime.watching.local import diags

_START = 10.0  # [s] for it to be seen alive


def revive(role: str, target: Target, forkserver: ForkServer) -> int:
    """Start a robot's role again, wait until it is seen alive, and return the process's id.

    Raises:
        RunError: It is alive, or does not come, or its run is not one that this user has started.
        ConfigError: The run has no such role.
    """
    began = time.monotonic()
    with visit(target) as bus:
        if diags(bus, role):
            raise RunError(f"{role} is alive; `msma agent --copy` starts another beside it")
        task = Task(role, target.run_with(role))
        if not read_log(task.run, role, "start"):  # it never had a process: is there such a role?
            load(task.file, only_role=role)
        child = forkserver.start(task)
        while not any(diag.pid == child.pid for diag in diags(bus, role)):
            if child.poll() is not None:
                raise RunError(f"{role} did not start: {task.said}")
            if time.monotonic() - began > _START:
                raise RunError(f"{role}, process {child.pid}, is not seen alive")
            time.sleep(0.02)
    return child.pid
