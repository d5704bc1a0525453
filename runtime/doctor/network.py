"""What can be wrong with a robot's place: its hosts, its ports, and who else is there."""

import socket
import time
from collections.abc import Iterable, Iterator
from contextlib import suppress
from ipaddress import ip_address
from typing import NamedTuple

from runtime import VERSION
from runtime.config.deployment import Deployment
from runtime.doctor.machine import Finding, Grade
from runtime.watching.discovery import Target, is_taken, robots_here
from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.fields import MessageError
from runtime.wire.mesh import SLOTS, Address
from runtime.wire.messages import Diag, unpack

_ANSWER = 1.0  # [s] for a host or a process
_CLOCKS = 0.1  # [s] by which clocks may differ before logs are hard to read side by side


class Told(NamedTuple):
    """What a process says, and by how much its host's clock is ahead [s], give or take."""

    diag: Diag
    ahead: float
    give: float


def hosts(deployment: Deployment) -> Iterator[Finding]:
    """Look at the hosts of a deployment: can they be reached by their addresses."""
    if len(deployment.hosts) < 2:
        return
    for name, spec in deployment.hosts.items():
        grade, detail = _reach(spec.address, deployment.port)
        yield Finding(grade, f"host {name}", f"{spec.address} {detail}")
    addresses = [spec.address for spec in deployment.hosts.values()]
    local = [address for address in addresses if _is_loopback(address)]
    if local and len(local) < len(addresses):
        what = f"{', '.join(local)} is this machine only, seen from each: no other can dial it"
        yield Finding(Grade.BAD, "hosts", f"{what}; put its address on the network")


def place(target: Target, roles: int) -> Iterator[Finding]:
    """Look at a robot's place: who has its ports, and does anything run there."""
    here = set(robots_here())
    others = sorted(here - {target.robot})
    yield Finding(Grade.OK, "other robots", ", ".join(others) or "none run here")
    told: list[Told] = []
    with Bus(target.robot, "a tool", target.mesh.visitor(), 0, target.credentials) as bus:
        for answer, told_by in _ask_all(bus):
            if told_by is None:
                what = f"{answer} speaks another version of MSMA than this, which is {VERSION}"
                yield Finding(Grade.BAD, "versions", what)
            else:
                told.append(told_by)
    if told:
        yield from running(target.robot, told)
        return
    if target.robot in here:
        what = "another robot of this name runs here, on other ports or hosts than this file's"
        yield Finding(Grade.BAD, target.robot, f"{what}; name one of them otherwise: --robot NAME")
    yield from _ports(target, roles)


def _reach(address: str, port: int) -> tuple[Grade, str]:
    try:
        with socket.create_connection((address, port), timeout=_ANSWER):
            return Grade.OK, "can be reached"
    except ConnectionRefusedError:
        return Grade.OK, "can be reached"
    except socket.gaierror as error:
        return Grade.BAD, f"is no name that this machine knows: {error.strerror}"
    except OSError as error:
        why = "it does not answer" if isinstance(error, TimeoutError) else error.strerror
        return Grade.BAD, f"cannot be reached: {why}; is it on, its cable in, its address right?"


def _is_loopback(address: str) -> bool:
    with suppress(OSError, ValueError):
        return ip_address(socket.getaddrinfo(address, None)[0][4][0]).is_loopback
    return False


def _ask_all(bus: Bus) -> Iterator[tuple[str, Told | None]]:
    """Yield the key of each answer, and what it says; None if that is not understood."""
    asked = time.time()
    answers = bus.ask(topics.EVERY_DIAG, timeout=_ANSWER)
    answered = time.time()
    for answer in answers:
        try:
            diag = unpack(Diag, answer.data)
        except MessageError:
            yield answer.key, None
        else:
            give = (answered - asked) / 2
            yield answer.key, Told(diag, diag.clock / 1e6 - asked - give, give)


def running(robot: str, told: list[Told]) -> Iterator[Finding]:
    """Look at a robot that runs."""
    there = ", ".join(sorted({one.diag.role for one in told}))
    yield Finding(Grade.WARN, robot, f"runs already: {there}; `msma stop` ends it")
    plants = [one.diag for one in told if one.diag.role == topics.PLANT]
    if not plants:
        detail = "none there: the others end by themselves; `msma revive plant` starts one"
        yield Finding(Grade.BAD, "plant", detail)
    elif len(plants) > 1:
        where = ", ".join(f"process {diag.pid} on {diag.host}" for diag in plants)
        what = f"{len(plants)} plants answer: {where}; name one of these robots otherwise"
        yield Finding(Grade.BAD, robot, what)
    yield from _versions(one.diag for one in told)
    for host in sorted({one.diag.host for one in told}):
        best = min((one for one in told if one.diag.host == host), key=lambda one: one.give)
        if abs(best.ahead) > _CLOCKS + best.give:
            way = "ahead" if best.ahead > 0 else "behind"
            what = f"that of {host} is {abs(best.ahead):.2f} s {way}; nothing but logs goes by it"
            yield Finding(Grade.WARN, "clocks", what)


def _versions(diags: Iterable[Diag]) -> Iterator[Finding]:
    others = sorted({(diag.version, diag.host) for diag in diags if diag.version != VERSION})
    for version, host in others:
        what = f"{host} has {version}, this machine {VERSION}; install the same on both"
        yield Finding(Grade.BAD, "versions", what)


def _ports(target: Target, roles: int) -> Iterator[Finding]:
    """Look at the ports of a robot that does not run, on the hosts that this machine is."""
    base = target.mesh.base
    ports = f"{base} to {base + SLOTS - 1}"
    ours = [address for address in target.mesh.addresses if not is_taken(0, address)]
    taken = [
        Address(address, port)
        for address in ours
        for port in range(base, base + SLOTS)
        if is_taken(port, address)
    ]
    if not ours:
        where = ", ".join(target.mesh.addresses)
        yield Finding(Grade.WARN, "ports", f"this machine is no host of it: {where}")
    elif not taken:
        yield Finding(Grade.OK, "ports", f"{ports} are free")
    else:
        wanted = any(port < base + roles for _, port in taken)
        numbers = ", ".join(str(port) for _, port in taken)
        detail = f"{numbers} of {ports} taken by others; set `port` in the file"
        yield Finding(Grade.BAD if wanted else Grade.WARN, "ports", detail)
