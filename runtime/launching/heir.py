"""Carries out what is left of a run's chaos once its launcher has killed itself.

Run as `python -m runtime.launching.heir RUN T`: what is due after plant time T [s].
"""

import os
import secrets
import signal
import sys
import time
from pathlib import Path

from runtime.config.deployment import Deployment, load
from runtime.launching.children import Children, send
from runtime.launching.havoc import Havoc
from runtime.launching.logs import read_log
from runtime.launching.saying import say
from runtime.launching.schedule import Schedule
from runtime.launching.starting import spawn
from runtime.launching.watcher import Watcher
from runtime.processes.journal import Journal
from runtime.processes.life import Life
from runtime.wire.bus import Bus
from runtime.wire.keys import PLANT
from runtime.wire.security import OPERATOR

_TURN = 0.02  # [s] between two looks at plant time


def bequeath(run: Path, t: float) -> None:
    """Start an heir for what is due in a run after plant time `t` [s]; it outlives this process."""
    spawn("runtime.launching.heir", [str(run), repr(t)], run / "heir.out")


def inherit(run: Path, t: float) -> None:
    """Go on with the chaos of a run after plant time `t` [s], until its end."""
    deployment = load(run / "deployment.yaml", only_role=PLANT)
    schedule = Schedule(deployment.chaos)
    begun = {due.event for due in schedule.due(t) if not due.over}
    journal = Journal(run, "heir")
    journal.write(t, "start", role="heir", pid=os.getpid())
    journal.flush()
    children = Children(run)
    place, credentials = deployment.mesh.visitor(), deployment.credentials(OPERATOR)
    with Bus(deployment.robot, "heir", place, secrets.randbits(63), credentials) as bus:
        watcher = Watcher(bus)
        havoc = Havoc(deployment, children, watcher, journal, show=say, happened=say)
        for event in begun:
            if event.hang is not None:
                havoc.hung[event] = _hung(run, event.hang)
        try:
            _stay(deployment, schedule, watcher, havoc)
        finally:
            for pids in havoc.hung.values():
                for pid in pids:
                    send(pid, signal.SIGKILL)  # nobody else would end who hangs
            journal.close()


def _stay(deployment: Deployment, schedule: Schedule, watcher: Watcher, havoc: Havoc) -> None:
    life = Life(
        patience=deployment.patience,
        duration=deployment.duration,
        speed=deployment.speed,
        now=time.monotonic(),
    )
    view = watcher.look()
    while not life.over(time.monotonic()) and not life.forlorn(time.monotonic()):
        before, view = view.t, watcher.look()
        if view.t != before:
            life.plant_heard(view.t, time.monotonic())
        for due in schedule.due(min(before, view.t)):
            havoc.carry_out(due)
        time.sleep(_TURN)


def _hung(run: Path, role: str) -> list[int]:
    """Return the processes that the launcher hung last in a role, unless it woke them."""
    done = [line for line in read_log(run, "launcher", "chaos") if line["target"] == role]
    return done[-1]["pids"] if done and done[-1]["action"] == "hang" else []


if __name__ == "__main__":
    inherit(Path(sys.argv[1]), float(sys.argv[2]))
