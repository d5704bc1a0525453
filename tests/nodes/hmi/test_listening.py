"""A page that other computers can reach: by TLS alone, and by its token."""

import asyncio
import json
import socket
import ssl
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import ExitStack
from http.client import HTTPSConnection
from pathlib import Path
from typing import Any, NamedTuple

import pytest
from cryptography.hazmat.primitives import serialization
from websockets.asyncio.client import connect
from websockets.exceptions import InvalidStatus

from nodes.hmi.address import Address
from nodes.hmi.listening import DoorError, tls_context
from runtime.tls.certificates import Authority
from tests.nodes.hmi.client import as_browser
from tests.nodes.hmi.conftest import WebRobot
from tests.runtime.conftest import ROOT

HERE = "127.0.0.2"  # no name of this computer that the page knows by itself, yet nobody else's


class Keys(NamedTuple):
    """Files of a certificate and its key, and of the authority that has signed it."""

    authority: Path
    certificate: Path
    key: Path


def made(folder: Path, *names: str) -> Keys:
    """Make an authority, and a certificate for these names."""
    folder.mkdir()
    authority = Authority("a test", 1)
    pair = authority.issue("page", names)
    texts = authority.certificate, pair.certificate, pair.private_key
    keys = Keys(*(folder / f"{name}.pem" for name in Keys._fields))
    for file, text in zip(keys, texts, strict=True):
        file.write_text(text)
    return keys


@pytest.fixture(scope="module")
def keys(tmp_path_factory: pytest.TempPathFactory) -> Keys:
    return made(tmp_path_factory.mktemp("keys") / "page", HERE, "robot.test")


class Served(NamedTuple):
    """A robot whose page listens with a certificate."""

    robot: WebRobot
    address: Address
    trusting: ssl.SSLContext


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory, keys: Keys) -> Iterator[Served]:
    with ExitStack() as stack:
        robot = WebRobot(tmp_path_factory.mktemp("robot"), stack)
        file, given = str(ROOT / "deploy" / "arph.yaml"), {"listen": HERE, "name": "robot.test"}
        given |= {"certificate": str(keys.certificate), "key": str(keys.key)}
        options = [word for name, value in given.items() for word in (f"--{name}", value)]
        address = robot.start_web(file, *options)
        yield Served(robot, address, ssl.create_default_context(cafile=keys.authority))


def get(served: Served, path: str, **headers: str) -> tuple[int, str]:
    """Ask for a file of the page: the status, and the cookie that is set."""
    port, context = served.address.port, served.trusting
    connection = HTTPSConnection(HERE, port, timeout=20.0, context=context)
    connection.request("GET", path, headers=headers)
    answer = connection.getresponse()
    found = answer.status, answer.getheader("Set-Cookie", "")
    connection.close()
    return found


def first_message(served: Served, **options: Any) -> dict[str, Any]:
    """Open the socket and return what is said first.

    It reads and writes in one thread: the client of websockets with two may do both at the same
    time, and with TLS the request then got lost now and then, most of all on a busy machine.
    """

    async def first() -> dict[str, Any]:
        url, sent = as_browser(served.address, ssl=served.trusting, **options)
        async with asyncio.timeout(20.0), connect(url, **sent) as opened:
            message: dict[str, Any] = json.loads(await opened.recv())
            return message

    with ThreadPoolExecutor(1) as thread:  # in that of the test Playwright may have a loop
        return thread.submit(lambda: asyncio.run(first())).result()


def test_by_tls_the_page_is_there_for_who_has_its_token(served: Served) -> None:
    address = served.address
    assert address.origin == f"https://{HERE}:{address.port}"
    assert get(served, "/")[0] == 403
    assert get(served, "/?token=wrong")[0] == 403
    status, cookie = get(served, f"/?token={address.operator}")
    assert status == 200
    assert {"Secure", "HttpOnly", "SameSite=Strict"} <= {part.strip() for part in cookie.split(";")}
    sent = {"Cookie": cookie.partition(";")[0]}
    assert get(served, "/", **sent)[0] == 200
    assert get(served, "/", Host=f"robot.test:{address.port}", **sent)[0] == 200
    assert get(served, "/", Host=f"127.0.0.1:{address.port}", **sent)[0] == 421
    hello = first_message(served)
    assert (hello["type"], hello["role"]) == ("hello", "operator")
    plain = address.origin.replace("https", "http")
    refusals: list[dict[str, Any]] = [{"origin": plain}, {"additional_headers": {}}]
    for wrong in refusals:
        with pytest.raises(InvalidStatus, match="403"):
            first_message(served, **wrong)


def test_who_does_not_trust_the_certificate_or_speaks_plain_http_gets_nothing(
    served: Served,
) -> None:
    stranger = served._replace(trusting=ssl.create_default_context())
    with pytest.raises(ssl.SSLCertVerificationError):
        get(stranger, "/")
    with socket.create_connection((HERE, served.address.port), 20.0) as plain:
        plain.sendall(f"GET /?token={served.address.operator} HTTP/1.1\r\n\r\n".encode())
        assert not plain.recv(4096).startswith(b"HTTP")
    assert get(served, "/")[0] == 403  # it goes on


def test_a_page_for_others_without_a_certificate_is_refused_before_anything_starts(
    tmp_path: Path,
) -> None:
    with ExitStack() as stack:
        robot = WebRobot(tmp_path, stack)
        file = str(ROOT / "deploy" / "arph-web.yaml")
        said = robot.msma("validate", file, "--set", f"nodes.hmi.listen={HERE}")
        assert said.returncode == 2
        assert "Give a certificate and its key" in said.stderr
        said = robot.msma_web(file, "--robot", robot.name, "--listen", HERE)
        assert said.returncode == 2
        assert "its file has a page" in said.stderr
        bare = str(ROOT / "deploy" / "arph.yaml")
        said = robot.msma_web(bare, "--robot", robot.name, "--listen", HERE)
        assert said.returncode == 2
        assert "Give a certificate and its key" in said.stderr
        assert not (robot.folder / "runs").exists()


def encrypted(keys: Keys, file: Path) -> Path:
    """Write the key as one that needs a password."""
    key = serialization.load_pem_private_key(keys.key.read_bytes(), None)
    kind = serialization.Encoding.PEM, serialization.PrivateFormat.PKCS8
    file.write_bytes(key.private_bytes(*kind, serialization.BestAvailableEncryption(b"secret")))
    return file


def test_files_that_are_no_pair_of_certificate_and_key_are_refused(
    tmp_path: Path, keys: Keys
) -> None:
    assert tls_context(keys.certificate, keys.key) is not None
    other = made(tmp_path / "other", HERE)
    wrong = {
        "of another": (keys.certificate, other.key),
        "the wrong way round": (keys.key, keys.certificate),
        "not there": (keys.certificate, tmp_path / "nowhere.pem"),
        "a folder": (tmp_path, keys.key),
        "with a password": (keys.certificate, encrypted(keys, tmp_path / "secret.pem")),
    }
    for certificate, key in wrong.values():
        with pytest.raises(DoorError, match=r"^certificate: .* cannot be used"):
            tls_context(certificate, key)
