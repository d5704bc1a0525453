"""The stage of a rehearsal: a namespace for each host, their cables, and the switch between."""

import ipaddress
import json
import os
import shutil
import socket
import subprocess
import sys
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Self

from runtime.config.chaos import LAUNCHER, WATCHER, ChaosEvent
from runtime.config.deployment import Deployment
from runtime.config.tree import ConfigError
from runtime.errors import RunError
from runtime.rehearsal.links import Trouble
from runtime.rehearsal.tap import leave_the_network, open_cable
from runtime.spawning.remote import out_of

_SOURCES = Path(__file__).parents[2]
_PATIENCE = 20.0  # [s] for a host to be there
_NAMESPACES = ("--net", "--uts", "--pid", "--fork", "--mount-proc", "--kill-child=SIGKILL")
_HOSTS, _OUR_ADDRESS = "10.87.0.{}", "10.87.255.254"


class Stage:
    """Makes the hosts of a deployment on this machine while in its `with` block.

    All of it goes with this process, however that ends: namespaces have no names, and what runs
    in one ends with its first process, which ends when nobody is at the other end of its input.
    """

    def __init__(self, deployment: Deployment) -> None:
        _check(deployment)
        self.deployment = _addressed(deployment)
        self.hosts: dict[str, subprocess.Popen[bytes]] = {}
        self._stack = ExitStack()

    def build(self, run: Path) -> None:
        """Make the hosts; what they complain of goes to the run's folder."""
        try:
            leave_the_network()
            cables = {"": open_cable(_OUR_ADDRESS)}
        except OSError as error:
            raise RunError(f"the rehearsal has no network: {error}") from None
        takers = {name: self._start(name, run) for name in self.deployment.hosts}
        for name, taker in takers.items():
            cables[name] = _take_cable(taker, name, run)
        self._start_switch(cables)
        for cable in cables.values():
            os.close(cable)

    def _start(self, name: str, run: Path) -> socket.socket:
        """Start a host; return the socket by which its cable will come."""
        taker, giver = socket.socketpair()
        address = self.deployment.hosts[name].address
        with giver, out_of(run, name).open("ab") as out:
            process = subprocess.Popen(
                ["unshare", *_NAMESPACES, *_python("host"), name, address, str(giver.fileno())],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=out,
                pass_fds=[giver.fileno()],
                start_new_session=True,
                env=_environment(),
            )
        self.hosts[name] = process
        self._stack.callback(_end, process)
        return self._stack.enter_context(taker)

    def _start_switch(self, cables: dict[str, int]) -> None:
        self._control, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._stack.enter_context(self._control)
        with theirs:
            pairs = [f"{name}={cable}" for name, cable in cables.items()]
            seed = str(self.deployment.seed)
            switch = subprocess.Popen(
                [*_python("switch"), str(theirs.fileno()), seed, *pairs],
                stdin=subprocess.DEVNULL,
                pass_fds=[theirs.fileno(), *cables.values()],
                start_new_session=True,
                env=_environment(),
            )
        self._stack.callback(_end, switch)

    def begin(self, event: ChaosEvent) -> None:
        """Begin a partition, a delay or a loss for the event's hosts."""
        hosts = frozenset(event.hosts)
        trouble = Trouble(
            event.action, hosts, event.time or 0.0, event.jitter or 0.0, event.share or 0.0
        )
        self._order(name=repr(event), trouble={**trouble._asdict(), "hosts": event.hosts})

    def end(self, event: ChaosEvent) -> None:
        """End what `begin` began for that event."""
        self._order(name=repr(event))

    def _order(self, **order: object) -> None:
        """Let the switch do something, and wait until it has."""
        self._control.send(json.dumps(order).encode())
        self._control.recv(16)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._stack.close()


def _check(deployment: Deployment) -> None:
    """Raise `ConfigError` if it cannot be rehearsed here."""
    if os.geteuid() != 0:
        raise ConfigError("--rehearse makes network namespaces, which takes root: run it by sudo")
    if not os.path.exists("/dev/net/tun"):
        raise ConfigError("--rehearse needs /dev/net/tun: `modprobe tun` makes it")
    if shutil.which("unshare") is None:
        raise ConfigError("--rehearse needs `unshare`, which is in the package util-linux")
    for index, event in enumerate(deployment.chaos):
        if (event.kill or event.hang) == WATCHER or event.kill == LAUNCHER:
            what = f"chaos.{index}: the hosts of a rehearsal end with its launcher, and no"
            raise ConfigError(f"{what} `msma status` runs beside it: {event.target} stays out")


def _addressed(deployment: Deployment) -> Deployment:
    """Give each host an address of its own, if those of the file will not do for that."""
    hosts = deployment.hosts
    addresses = {spec.address for spec in hosts.values()}
    if len(addresses) == len(hosts) and all(map(_will_do, addresses)):
        return deployment
    if deployment.security is not None:
        what = "certificates hold the addresses of `hosts`: to be rehearsed they must be IPv4"
        raise ConfigError(f"{what} addresses, each another and none of the loopback device")
    numbered = {
        name: replace(spec, address=_HOSTS.format(index + 1))
        for index, (name, spec) in enumerate(hosts.items())
    }
    return replace(deployment, hosts=numbered)


def _will_do(address: str) -> bool:
    try:
        parsed = ipaddress.IPv4Address(address)
    except ValueError:
        return False
    return not parsed.is_loopback and address != _OUR_ADDRESS


def _take_cable(taker: socket.socket, name: str, run: Path) -> int:
    taker.settimeout(_PATIENCE)
    try:
        _, files, _, _ = socket.recv_fds(taker, 16, 1)
    except TimeoutError:
        files = []
    if not files:
        raise RunError(f"host {name} of the rehearsal did not begin: see {out_of(run, name)}")
    return files[0]


def _python(module: str) -> list[str]:
    return [sys.executable, "-P", "-m", f"runtime.rehearsal.{module}"]


def _environment() -> dict[str, str]:
    path = os.pathsep.join(filter(None, (str(_SOURCES), os.environ.get("PYTHONPATH"))))
    return {**os.environ, "PYTHONPATH": path}


def _end(process: "subprocess.Popen[bytes]") -> None:
    process.kill()
    process.wait()
    for pipe in (process.stdin, process.stdout):
        if pipe is not None:
            pipe.close()
