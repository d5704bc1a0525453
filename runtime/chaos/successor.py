"""Carries out what is left of a run's chaos once its launcher has killed itself.

Run as `python -m runtime.chaos.successor RUN T`: what is due after plant time T [s].
"""

import secrets
import sys
import time
from pathlib import Path
from signal import SIGKILL

from runtime.chaos.injector import ANSWER, FaultInjector
from runtime.chaos.schedule import Schedule
from runtime.config.deployment import load
from runtime.processes.log_writer import LogWriter
from runtime.results.logs import read_log
from runtime.spawning.identity import start_line
from runtime.spawning.local import LocalProcesses
from runtime.spawning.tasks import spawn
from runtime.watching.control import Control
from runtime.watching.table import say
from runtime.watching.watcher import Watcher
from runtime.wire.bus import Bus
from runtime.wire.security import OPERATOR
from runtime.wire.topics import PLANT

_TURN = 0.02  # [s] between two looks at plant time


def start_successor(run: Path, t: float) -> None:
    """Start a successor for what is due after plant time `t` [s]; it outlives this process."""
    spawn("runtime.chaos.successor", [str(run), repr(t)], run / "successor.out")


def inherit(run: Path, t: float) -> None:
    """Go on with the chaos of a run after plant time `t` [s], until its end."""
    deployment = load(run / "deployment.yaml", only_role=PLANT)
    schedule = Schedule(deployment.chaos)
    begun = {due.event for due in schedule.due(t) if not due.over}
    log = LogWriter(run, "successor")
    log.write(t, "start", **start_line("successor", deployment.robot, run))
    log.flush()
    processes = LocalProcesses(run)
    place, credentials = deployment.mesh.visitor(), deployment.credentials(OPERATOR)
    with Bus(deployment.robot, "successor", place, secrets.randbits(63), credentials) as bus:
        watcher = Watcher(bus)
        control = Control(bus, processes, ANSWER)
        injector = FaultInjector(deployment, control, watcher, log, show=say, happened=say)
        for event in begun:
            if event.hang is not None:
                injector.hung[event] = _hung(run, event.hang)
        try:
            while not watcher.clock.end(deployment, time.monotonic()):
                for due in schedule.due(watcher.look().t):
                    injector.carry_out(due)
                time.sleep(_TURN)
        finally:
            for event, pids in injector.hung.items():
                control.send(event.target, pids, SIGKILL)  # nothing else would end what hangs
            log.close()


def _hung(run: Path, role: str) -> list[int]:
    """Return the processes that the launcher hung last in a role, unless it woke them."""
    done = [line for line in read_log(run, "launcher", "chaos") if line["target"] == role]
    return done[-1]["pids"] if done and done[-1]["action"] == "hang" else []


if __name__ == "__main__":
    inherit(Path(sys.argv[1]), float(sys.argv[2]))
