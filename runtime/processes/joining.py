"""How a process finds its place among the others of its robot, and the run they are in."""

import time
from pathlib import Path

from runtime.config.deployment import Deployment, ProcessSpec
from runtime.wire import topics
from runtime.wire.bus import Bus, BusError
from runtime.wire.mesh import FIRST_COPY, SLOTS, Endpoints
from runtime.wire.messages import Diag, unpack
from runtime.wire.refusals import MessageError

_SEARCH = 0.6  # [s] in which those who dial us have found us


def join(deployment: Deployment, member: ProcessSpec, incarnation: int) -> Bus:
    """Return the process's place on the bus, or `BusError` if it is taken.

    A copy, which stands by for a role that runs already, takes the first free place of those
    for copies.
    """
    mesh, role = deployment.mesh, member.role
    credentials = deployment.credentials(role)

    def take(place: Endpoints) -> Bus:
        return Bus(deployment.robot, role, place, incarnation, credentials)

    if not member.copy:
        return take(mesh.seat(deployment.slot(role)))
    home = deployment.hosts[member.host].address
    for slot in range(FIRST_COPY, SLOTS):
        try:
            return take(mesh.copy_seat(slot, home))
        except BusError as error:
            taken = error
    raise taken


def find_run(bus: Bus) -> Path | None:
    """Return the folder of the run that the other processes on the bus are in, if it is here."""
    until = time.monotonic() + _SEARCH
    while time.monotonic() < until:
        runs = {}
        for answer in bus.ask(topics.EVERY_DIAG, timeout=_SEARCH):
            try:
                diag = unpack(Diag, answer.data)
            except MessageError:
                continue
            runs[diag.role] = Path(diag.run)
        if runs:
            told = [runs[topics.PLANT]] if topics.PLANT in runs else []
            return next((run for run in [*told, *runs.values()] if run.is_dir()), None)
        time.sleep(0.05)
    return None
