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
from runtime.launching.journal import Journal
from runtime.results.logs import read_log
from runtime.spawning.identity import start_line
from runtime.spawning.local import LocalProcesses
from runtime.spawning.tasks import spawn
from runtime.watching.control import Control
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
    hung = {due.event for due in schedule.due(t) if due.event.hang}
    journal = Journal(deployment, run, "successor")
    journal.t = t
    journal.write("start", **start_line("successor", deployment.robot, run))
    journal.log.flush()
    processes = LocalProcesses(run)
    place, credentials = deployment.mesh.visitor(), deployment.credentials(OPERATOR)
    with Bus(deployment.robot, "successor", place, secrets.randbits(63), credentials) as bus:
        watcher, control = Watcher(bus), Control(bus, processes, ANSWER)
        injector = FaultInjector(deployment, control, journal)
        injector.hung = {event: _hung(run, event.target) for event in hung}
        try:
            while not watcher.clock.end(deployment, time.monotonic()):
                journal.t = watcher.look().t
                for due in schedule.due(journal.t):
                    injector.carry_out(due)
                time.sleep(_TURN)
        finally:
            for event, pids in injector.hung.items():
                processes.send(event.target, pids, SIGKILL)  # nothing else would end what hangs
            journal.log.close()


def _hung(run: Path, role: str) -> list[int]:
    """Return the processes that the launcher hung last in a role, unless it woke them."""
    done = [line for line in read_log(run, "launcher", "chaos") if line["target"] == role]
    return done[-1]["pids"] if done and done[-1]["action"] == "hang" else []


if __name__ == "__main__":
    inherit(Path(sys.argv[1]), float(sys.argv[2]))
