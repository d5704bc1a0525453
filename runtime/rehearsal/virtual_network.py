"""The virtual hosts of a rehearsal, each in namespaces of its own, and the switch between them."""

import ipaddress
import os
import shutil
import socket
import subprocess
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Self

import msgspec

from runtime.config.chaos import LAUNCHER, WATCHER, ChaosEvent
from runtime.config.deployment import Deployment
from runtime.config.tree import ConfigError
from runtime.errors import RunError
from runtime.rehearsal.links import Impairment
from runtime.rehearsal.tap import enter_new_network, open_tap
from runtime.spawning.remote import out_of
from runtime.spawning.tasks import environment, python

_START_TIMEOUT = 20.0  # [s]
_NAMESPACES = ("--net", "--uts", "--pid", "--fork", "--mount-proc", "--kill-child=SIGKILL")
_HOSTS, _OUR_ADDRESS = "10.87.0.{}", "10.87.255.254"


class VirtualNetwork:
    """Creates the hosts of a deployment on this machine for the time of its `with` block.

    Everything ends with this process, however it ends: the namespaces have no names, and all that
    runs in one ends with its first process, which ends when its standard input closes.

    Attributes:
        deployment: The deployment, with an address of its own for each host.
        hosts: The first process of each host.

    Raises:
        ConfigError: The deployment cannot be rehearsed on this machine.
    """

    def __init__(self, deployment: Deployment) -> None:
        _check(deployment)
        self.deployment = _addressed(deployment)
        self.hosts: dict[str, subprocess.Popen[bytes]] = {}
        self._stack = ExitStack()
        self._impairing: list[ChaosEvent] = []

    def build(self, run: Path) -> None:
        """Create the hosts; their error output goes to the run's folder."""
        try:
            enter_new_network()
            taps = {"": open_tap(_OUR_ADDRESS)}
        except OSError as error:
            raise RunError(f"the network of the rehearsal cannot be created: {error}") from None
        receivers = {name: self._start(name, run) for name in self.deployment.hosts}
        for name, receiver in receivers.items():
            taps[name] = _receive_tap(receiver, name, run)
        self._start_switch(taps)
        for tap in taps.values():
            os.close(tap)

    def _start(self, name: str, run: Path) -> socket.socket:
        """Start a host; return the socket that will receive its TAP device."""
        receiver, sender = socket.socketpair()
        host = python("runtime.rehearsal.host", name, self.deployment.hosts[name].address)
        with sender, out_of(run, name).open("ab") as out:
            process = subprocess.Popen(
                ["unshare", *_NAMESPACES, *host, str(sender.fileno())],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=out,
                pass_fds=[sender.fileno()],
                start_new_session=True,
                env=environment(),
            )
        self.hosts[name] = process
        self._ends_with_us(process)
        return self._stack.enter_context(receiver)

    def _start_switch(self, taps: dict[str, int]) -> None:
        self._control, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._stack.enter_context(self._control)
        with theirs:
            pairs = [f"{name}={tap}" for name, tap in taps.items()]
            seed = str(self.deployment.seed)
            switch = subprocess.Popen(
                python("runtime.rehearsal.switch", str(theirs.fileno()), seed, *pairs),
                stdin=subprocess.DEVNULL,
                pass_fds=[theirs.fileno(), *taps.values()],
                start_new_session=True,
                env=environment(),
            )
        self._ends_with_us(switch)

    def _ends_with_us(self, process: "subprocess.Popen[bytes]") -> None:
        self._stack.enter_context(process)
        self._stack.callback(process.kill)

    def begin(self, event: ChaosEvent) -> None:
        """Begin a partition, a delay or a loss for the event's hosts."""
        self._impairing.append(event)
        self._impair()

    def end(self, event: ChaosEvent) -> None:
        """End what `begin` began for the event."""
        self._impairing.remove(event)
        self._impair()

    def _impair(self) -> None:
        """Send all impairments to the switch, and wait until it has them."""
        impairments = [
            Impairment(
                one.action,
                frozenset(one.hosts),
                time=one.time or 0.0,
                jitter=one.jitter or 0.0,
                share=one.share or 0.0,
            )
            for one in self._impairing
        ]
        self._control.send(msgspec.json.encode(impairments))
        self._control.recv(16)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()


def _check(deployment: Deployment) -> None:
    """Raise `ConfigError` if a deployment cannot be rehearsed on this machine."""
    if os.geteuid() != 0:
        raise ConfigError("--rehearse creates network namespaces and must run as root: use sudo")
    if not os.path.exists("/dev/net/tun"):
        raise ConfigError("--rehearse needs /dev/net/tun: load it with `modprobe tun`")
    if shutil.which("unshare") is None:
        raise ConfigError("--rehearse needs `unshare`: install the package util-linux")
    for index, event in enumerate(deployment.chaos):
        if (event.kill or event.hang) == WATCHER or event.kill == LAUNCHER:
            what = f"chaos.{index}: --rehearse cannot {event.action} the {event.target}"
            raise ConfigError(f"{what}: its hosts end with the launcher, and it has no watcher")


def _addressed(deployment: Deployment) -> Deployment:
    """Return the deployment, with new addresses unless those of the file can be used."""
    hosts = deployment.hosts
    addresses = {spec.address for spec in hosts.values()}
    if len(addresses) == len(hosts) and all(map(_is_usable, addresses)):
        return deployment
    if deployment.security is not None:
        what = "with `security`, --rehearse needs an IPv4 address of its own for each host"
        raise ConfigError(f"{what}, none of them loopback: the certificates contain them")
    numbered = {
        name: replace(spec, address=_HOSTS.format(index + 1))
        for index, (name, spec) in enumerate(hosts.items())
    }
    return replace(deployment, hosts=numbered)


def _is_usable(address: str) -> bool:
    try:
        parsed = ipaddress.IPv4Address(address)
    except ValueError:
        return False
    return not parsed.is_loopback and address != _OUR_ADDRESS


def _receive_tap(receiver: socket.socket, name: str, run: Path) -> int:
    receiver.settimeout(_START_TIMEOUT)
    try:
        _, files, _, _ = socket.recv_fds(receiver, 16, 1)
    except TimeoutError:
        files = []
    if not files:
        raise RunError(f"host {name} of the rehearsal did not start: see {out_of(run, name)}")
    return files[0]
