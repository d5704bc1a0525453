"""What an engineer does to the processes of the run: kill, hang, resume, revive."""

import signal
import subprocess
import sys
from collections.abc import Iterable
from pathlib import Path

from plant.errors import MsmaError
from runtime.spawning.identity import obeyed_in, processes_in

_LONGEST = 20.0  # [s] that a tool may take
_SIGNALS = {"kill": signal.SIGKILL, "hang": signal.SIGSTOP, "resume": signal.SIGCONT}


class ActError(MsmaError, RuntimeError):
    """What could not be done to a process: it says why."""


def act(run: Path, roles: Iterable[str], what: str, role: str) -> None:
    """Do it, and wait until it is done; `ActError` if it cannot be.

    Args:
        run: The folder of the run.
        roles: All roles of the robot.
        what: `kill`, `hang`, `resume` or `revive`.
        role: Whose process.
    """
    if role not in roles:
        raise ActError(f"no process has the role {role}")
    if what == "revive":
        _tool("revive", role, "--file", str(run / "deployment.yaml"))
        return
    if what == "resume":
        found = processes_in(run, role)
    else:
        found = [one for one in [obeyed_in(run, role)] if one is not None]
    if not found:
        raise ActError(f"no process of {role} runs on this computer")
    for process in found:
        process.send(_SIGNALS[what])


def fault(run: Path, text: str) -> None:
    """Inject a fault into the robot of a run; `ActError` if it has no such fault."""
    _tool("fault", text, "--file", str(run / "deployment.yaml"))


def _tool(*arguments: str) -> None:
    """Do what a person would type: with all rights of who started this, and no child of this."""
    command = [sys.executable, "-m", "runtime.cli", *arguments]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=_LONGEST, check=False
        )
    except subprocess.TimeoutExpired:
        raise ActError(f"msma {arguments[0]} took more than {_LONGEST:g} s") from None
    if done.returncode != 0:
        said = (done.stderr.strip().splitlines() or ["it failed"])[-1]
        raise ActError(said.removeprefix("msma: ")[:200])
