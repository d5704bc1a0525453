"""How this machine reaches the page of a rehearsal: which port, and what passes its bytes on."""

import os
import socket
import subprocess
from collections.abc import Iterator
from contextlib import ExitStack, suppress
from pathlib import Path

import pytest

from runtime.config.deployment import Deployment, load
from runtime.config.overrides import Override
from runtime.config.tree import ConfigError
from runtime.rehearsal.virtual_network import VirtualNetwork
from runtime.spawning.tasks import environment, python
from runtime.wire.mesh import LOOPBACK, page_ports
from tests.ports import reserve_any
from tests.runtime.conftest import DEADLINE, ROOT

can_rehearse = pytest.mark.skipif(
    os.geteuid() != 0 or not Path("/dev/net/tun").exists(),
    reason="a rehearsal takes root and /dev/net/tun: run the tests as root",
)


@pytest.fixture
def inside() -> Iterator[socket.socket]:
    """Listen as the page does."""
    with socket.create_server((LOOPBACK, 0)) as page:
        page.settimeout(DEADLINE)
        yield page


@pytest.fixture
def forwarder(inside: socket.socket) -> Iterator[tuple["subprocess.Popen[bytes]", int]]:
    """Run a forwarder to what listens inside; yield it, and the port that leads there."""
    with ExitStack() as stack:
        door = stack.enter_context(socket.create_server((LOOPBACK, 0)))
        arguments = str(door.fileno()), str(inside.getsockname()[1])
        process = subprocess.Popen(
            python("runtime.rehearsal.forwarder", *arguments),
            stdin=subprocess.PIPE,
            pass_fds=[door.fileno()],
            env=environment(),
        )
        stack.enter_context(process)
        stack.callback(process.kill)
        yield process, door.getsockname()[1]


def test_bytes_go_both_ways_and_so_does_their_end(
    inside: socket.socket, forwarder: tuple["subprocess.Popen[bytes]", int]
) -> None:
    sent = bytes(range(256)) * 4096
    with socket.create_connection((LOOPBACK, forwarder[1]), DEADLINE) as browser:
        page, _ = inside.accept()
        page.settimeout(DEADLINE)
        with page:
            browser.sendall(b"question")
            browser.shutdown(socket.SHUT_WR)
            assert read_all(page) == b"question"
            page.sendall(sent)
        assert read_all(browser) == sent


def test_without_a_page_a_connection_ends_and_later_ones_go_on(
    inside: socket.socket, forwarder: tuple["subprocess.Popen[bytes]", int]
) -> None:
    port = inside.getsockname()[1]
    inside.close()
    with socket.create_connection((LOOPBACK, forwarder[1]), DEADLINE) as browser:
        assert read_all(browser) == b""
    with (
        socket.create_server((LOOPBACK, port)) as again,
        socket.create_connection((LOOPBACK, forwarder[1]), DEADLINE) as browser,
    ):
        page, _ = again.accept()
        with page:
            page.sendall(b"back")
        assert read_all(browser) == b"back"


def test_it_ends_with_its_launcher_also_while_somebody_looks(
    inside: socket.socket, forwarder: tuple["subprocess.Popen[bytes]", int]
) -> None:
    process, port = forwarder
    with socket.create_connection((LOOPBACK, port), DEADLINE) as browser:
        page, _ = inside.accept()
        with page:
            assert process.stdin is not None
            process.stdin.close()
            assert process.wait(DEADLINE) == 0
        assert read_all(browser) == b""


def read_all(connection: socket.socket) -> bytes:
    """Return what comes until the end, or until the connection is lost."""
    found = b""
    with suppress(ConnectionResetError):
        while data := connection.recv(65536):
            found += data
    return found


def deployed(base: int, port: str) -> Deployment:
    """Return a robot on three hosts with a page, whose ports begin at `base`."""
    page = f"[{{role: hmi, class: nodes.hmi.page:Page, port: {port}}}]"
    values = {"nodes": page, "port": str(base)}
    overrides = (Override("a test", path, value) for path, value in values.items())
    return load(ROOT / "deploy" / "arph-hosts.yaml", overrides)


@can_rehearse
def test_the_page_has_its_own_port_on_this_machine_or_the_next_that_is_free() -> None:
    base, reservation = reserve_any()
    with reservation, ExitStack() as stack:
        own = page_ports(base)[0]
        with suppress(OSError):  # or another program has it already
            stack.enter_context(socket.create_server((LOOPBACK, own)))
        network = stack.enter_context(VirtualNetwork(deployed(base, "null")))
        (page,) = network.deployment.nodes
        assert page.parameters["port"] in page_ports(base)
        assert page.parameters["port"] != own


@can_rehearse
def test_a_port_that_the_file_sets_and_that_is_taken_is_refused() -> None:
    base, reservation = reserve_any()
    with reservation, socket.create_server((LOOPBACK, 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(ConfigError, match=f"port {port} .* cannot be had.* role hmi"):
            VirtualNetwork(deployed(base, str(port)))
