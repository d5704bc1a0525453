"""Starting the process of a role again, in the run that goes on."""

import time

from runtime.config.deployment import load
from runtime.errors import RunError
from runtime.results.logs import read_log
from runtime.spawning.forkserver import ForkServer
from runtime.spawning.identity import processes_in
from runtime.spawning.local import LocalProcesses
from runtime.watching.control import Control
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
        run = target.run_with(role)
        host = ""  # which only a copy beside a process that hangs has to know
        if processes_in(run, role) or not read_log(run, role, "start"):
            host = load(run / "deployment.yaml", only_role=role).host_of(role)
        processes = LocalProcesses(run, forkserver)
        pid = Control(bus, processes).revive(role, host)
        while not any(diag.pid == pid for diag in diags(bus, role)):
            for ended in processes.ended():
                raise RunError(f"{role} did not start: {ended.said}")
            if time.monotonic() - began > _START:
                raise RunError(f"{role}, process {pid}, is not seen alive")
            time.sleep(0.02)
    return pid
