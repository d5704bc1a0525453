"""The virtual hosts of a rehearsal, each in namespaces of its own, and the switch between them."""

import ipaddress
import os
import socket
import subprocess
from collections.abc import Sequence
from contextlib import ExitStack, suppress
from dataclasses import replace
from pathlib import Path
from typing import IO

import msgspec

from runtime.config.chaos import LAUNCHER, WATCHER, ChaosEvent
from runtime.config.deployment import Deployment
from runtime.config.specs import NodeSpec
from runtime.config.tree import ConfigError
from runtime.errors import RunError
from runtime.rehearsal.tun import enter_new_network
from runtime.spawning.remote import out_of
from runtime.spawning.tasks import environment, python
from runtime.wire.mesh import LOOPBACK, page_ports
from runtime.wire.topics import PAGE

_NAMESPACES = ("--uts", "--pid", "--fork", "--mount-proc", "--kill-child=SIGKILL")
_HOSTS, _OUR_ADDRESS = "10.87.0.{}", "10.87.255.254"


class VirtualNetwork(ExitStack):
    """Creates the hosts of a deployment on this machine for the time of its `with` block.

    `ConfigError` if the deployment cannot be rehearsed on this machine.
    Everything ends with this process, however it ends: the namespaces have no names, and all that
    runs in one ends with its first process, which ends when its standard input closes.

    Attributes:
        deployment: The deployment, with an address of its own for each host, and the port at which
            this machine reaches its page.
        hosts: The first process of each host.
    """

    def __init__(self, deployment: Deployment) -> None:
        super().__init__()
        _check(deployment)
        self.deployment = _addressed(deployment)
        self._door = _open_door(deployment)
        if self._door is not None:
            self.enter_context(self._door)
            self.deployment = _with_page_port(self.deployment, self._door.getsockname()[1])
        self.hosts: dict[str, subprocess.Popen[bytes]] = {}
        self._impairing: list[ChaosEvent] = []

    def build(self, run: Path) -> None:
        """Create the hosts; their error output goes to the run's folder."""
        tuns = []
        try:
            for name, spec in self.deployment.hosts.items():
                tuns.append((enter_new_network(spec.address), spec.address, name))
                host = ["unshare", *_NAMESPACES, *python("runtime.rehearsal.host", name)]
                with out_of(run, name).open("ab") as out:  # it starts in the network just entered
                    self.hosts[name] = self._start(host, stderr=out)
                if self._door is not None and name == self.deployment.host_of(PAGE):
                    self._forward(self._door)
            tuns.append((enter_new_network(_OUR_ADDRESS), _OUR_ADDRESS, ""))
        except OSError as error:
            raise RunError(f"the network of the rehearsal cannot be created: {error}") from None
        ends = ["=".join(map(str, tun)) for tun in tuns]
        switch = python("runtime.rehearsal.switch", str(self.deployment.seed), *ends)
        files = [file for file, _, _ in tuns]
        self._switch = self._start(switch, pass_fds=files)
        for file in files:
            os.close(file)
        self._update_switch()  # when it answers there is a network

    def _forward(self, door: socket.socket) -> None:
        """Let who comes to a socket of this machine into the network just entered, to the page."""
        file, port = door.fileno(), door.getsockname()[1]
        self._start(python("runtime.rehearsal.forwarder", str(file), str(port)), pass_fds=[file])
        door.close()

    def _start(
        self, command: list[str], stderr: IO[bytes] | None = None, pass_fds: Sequence[int] = ()
    ) -> "subprocess.Popen[bytes]":
        """Start a process that ends with this one, for its standard input closes then."""
        process = subprocess.Popen(
            command,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=stderr,
            pass_fds=pass_fds,
            start_new_session=True,  # where no Ctrl-C reaches it
            env=environment(),
        )
        self.enter_context(process)
        self.callback(process.kill)
        return process

    def impair(self, event: ChaosEvent, *, over: bool) -> None:
        """Begin a partition, a delay or a loss for the event's hosts, or end it."""
        (self._impairing.remove if over else self._impairing.append)(event)
        self._update_switch()

    def _update_switch(self) -> None:
        """Send all impairments to the switch, and wait until it has them."""
        assert self._switch.stdin is not None
        assert self._switch.stdout is not None
        self._switch.stdin.write(msgspec.json.encode(self._impairing) + b"\n")
        self._switch.stdin.flush()
        self._switch.stdout.readline()


def _check(deployment: Deployment) -> None:
    """Raise `ConfigError` if a deployment cannot be rehearsed on this machine."""
    if os.geteuid() != 0:
        raise ConfigError("--rehearse creates network namespaces and must run as root: use sudo")
    if not os.path.exists("/dev/net/tun"):
        raise ConfigError("--rehearse needs /dev/net/tun: load it with `modprobe tun`")
    for index, event in enumerate(deployment.chaos):
        if (event.kill or event.hang) == WATCHER or event.kill == LAUNCHER:
            what = f"chaos.{index}: --rehearse cannot {event.action} the {event.target}"
            raise ConfigError(f"{what}: its hosts end with the launcher, and it has no watcher")


def _open_door(deployment: Deployment) -> socket.socket | None:
    """Listen on this machine for the page of a rehearsal; None if it has no page.

    That has to be before this process is in another network. The port is the page's own, or the
    next that is free, as without a rehearsal; `ConfigError` if the one that its file sets is taken.
    """
    page = deployment.specs.get(PAGE)
    if not isinstance(page, NodeSpec) or "port" not in page.parameters:
        return None  # none, or one of a class that does not say where it is
    given = page.parameters["port"]
    why = ""
    for port in page_ports(deployment.port) if given is None else [given]:
        try:
            return socket.create_server((LOOPBACK, port))
        except OSError as error:
            why = f"port {port} of this machine cannot be had for the page: {error.strerror}"
    raise ConfigError(f"{why}. Set another one: `port` of the node in the role {PAGE}")


def _with_page_port(deployment: Deployment, port: int) -> Deployment:
    """Return the deployment with a port for its page."""
    nodes = tuple(
        replace(node, parameters={**node.parameters, "port": port}) if node.role == PAGE else node
        for node in deployment.nodes
    )
    return replace(deployment, nodes=nodes)


def _addressed(deployment: Deployment) -> Deployment:
    """Return the deployment, with new addresses unless those of the file can be used."""
    hosts = deployment.hosts
    with suppress(ValueError):
        addresses = {ipaddress.IPv4Address(spec.address) for spec in hosts.values()}
        taken = any(one.is_loopback or str(one) == _OUR_ADDRESS for one in addresses)
        if len(addresses) == len(hosts) and not taken:
            return deployment
    if deployment.security is not None:
        what = "with `security`, --rehearse needs an IPv4 address of its own for each host"
        raise ConfigError(f"{what}, none of them loopback: the certificates contain them")
    numbered = {
        name: replace(spec, address=_HOSTS.format(index + 1))
        for index, (name, spec) in enumerate(hosts.items())
    }
    return replace(deployment, hosts=numbered)
