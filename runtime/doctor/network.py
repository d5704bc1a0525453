"""Checks of the network: a robot's hosts and ports, and other robots on this machine."""

import socket
import time
from collections.abc import Iterator
from contextlib import suppress
from ipaddress import ip_address

from runtime import VERSION
from runtime.config.deployment import Deployment
from runtime.doctor.machine import Finding, Grade
from runtime.spawning.ports import is_taken
from runtime.watching.discovery import Target, anything_connects, join, robots_here
from runtime.wire import topics
from runtime.wire.mesh import SLOTS
from runtime.wire.messages import Diag
from runtime.wire.packing import unpack
from runtime.wire.refusals import MessageError

_TIMEOUT = 1.0  # [s] for an answer from a host or a process
_CLOCKS = 0.1  # [s] by which clocks may differ: logs are compared by them


def check_hosts(deployment: Deployment) -> Iterator[Finding]:
    """Check that the hosts of a deployment can be reached at their addresses."""
    if len(deployment.hosts) < 2:
        return
    for name, spec in deployment.hosts.items():
        grade, detail = _reach(spec.address, deployment.port)
        yield Finding(grade, f"host {name}", f"{spec.address} {detail}")
    addresses = [spec.address for spec in deployment.hosts.values()]
    local = [address for address in addresses if _is_loopback(address)]
    if local and len(local) < len(addresses):
        what = f"{', '.join(local)} is a loopback address, which other hosts cannot reach"
        yield Finding(Grade.BAD, "hosts", f"{what}; give the host's address on the network")


def check_robot(target: Target, roles: int) -> Iterator[Finding]:
    """Check whether a robot runs already, and if not, whether its ports are free."""
    here = set(robots_here())
    others = sorted(here - {target.robot})
    yield Finding(Grade.OK, "other robots", ", ".join(others) or "none on this machine")
    diags: list[Diag] = []
    with join(target) as bus:
        if target.robot in here:  # a busy one that has yet to connect is not one with other ports
            anything_connects(bus, target)
        asked = time.time()
        answers = bus.ask(topics.EVERY_DIAG, timeout=_TIMEOUT)
        half = (time.time() - asked) / 2
        for answer in answers:
            try:
                diags.append(unpack(Diag, answer.data))
            except MessageError:
                what = f"{answer.key} is from another version of MSMA; this one is {VERSION}"
                yield Finding(Grade.BAD, "versions", what)
    if diags:
        yield from check_running(target.robot, diags, asked + half, half)
        return
    if target.robot in here:
        what = "another robot of this name runs on this machine, with other ports or hosts"
        yield Finding(Grade.BAD, target.robot, f"{what}; rename one of them: --robot NAME")
    yield from _ports(target, roles)


def _reach(address: str, port: int) -> tuple[Grade, str]:
    try:
        with socket.create_connection((address, port), timeout=_TIMEOUT):
            return Grade.OK, "can be reached"
    except ConnectionRefusedError:  # by a host that is there
        return Grade.OK, "can be reached"
    except socket.gaierror as error:
        return Grade.BAD, f"is an unknown host name: {error.strerror}"
    except OSError as error:
        why = "no answer" if isinstance(error, TimeoutError) else error.strerror
        return Grade.BAD, f"cannot be reached: {why}; check its power, cable and address"


def _is_loopback(address: str) -> bool:
    with suppress(OSError, ValueError):
        return ip_address(socket.getaddrinfo(address, None)[0][4][0]).is_loopback
    return False


def check_running(robot: str, diags: list[Diag], now: float, error: float) -> Iterator[Finding]:
    """Check a robot that runs: its plant, versions and clocks.

    Args:
        robot: Its name.
        diags: What its processes have answered.
        now: When they did so [s since 1970].
        error: Largest error of that time [s].
    """
    roles = ", ".join(sorted({diag.role for diag in diags}))
    yield Finding(Grade.WARN, robot, f"runs already: {roles}; stop it with `msma stop`")
    plants = [diag for diag in diags if diag.role == topics.PLANT]
    if not plants:
        detail = "is missing, so the other processes will end; start it with `msma revive plant`"
        yield Finding(Grade.BAD, "plant", detail)
    elif len(plants) > 1:
        where = ", ".join(f"process {diag.pid} on {diag.host}" for diag in plants)
        what = f"{len(plants)} plants answer: {where}; rename one of these robots"
        yield Finding(Grade.BAD, robot, what)
    for version, host in sorted({(diag.version, diag.host) for diag in diags}):
        if version != VERSION:
            what = f"{host} has {version}, this machine {VERSION}; install the same version on both"
            yield Finding(Grade.BAD, "versions", what)
    for host, clock in sorted({diag.host: diag.clock / 1e6 for diag in diags}.items()):
        if abs(clock - now) > _CLOCKS + error:
            way = "ahead" if clock > now else "behind"
            what = f"{host} is {abs(clock - now):.2f} s {way}; this affects only logs"
            yield Finding(Grade.WARN, "clocks", what)


def _ports(target: Target, roles: int) -> Iterator[Finding]:
    """Check the ports of a robot that does not run, at its addresses on this machine."""
    base = target.mesh.base
    ports = f"{base} to {base + SLOTS - 1}"
    here = [address for address in target.mesh.addresses if not is_taken(0, address)]
    every = range(base, base + SLOTS)
    taken = [port for address in here for port in every if is_taken(port, address)]
    if not here:
        where = ", ".join(target.mesh.addresses)
        yield Finding(Grade.WARN, "ports", f"this machine is not one of its hosts: {where}")
    elif not taken:
        yield Finding(Grade.OK, "ports", f"{ports} are free")
    else:
        grade = Grade.BAD if min(taken) < base + roles else Grade.WARN
        numbers = ", ".join(map(str, taken))
        detail = f"{numbers} of {ports} are in use by other programs; set `port` in the file"
        yield Finding(grade, "ports", detail)
