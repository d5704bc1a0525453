from pathlib import Path

import pytest

from nodes.hmi.address import Address, find_address, keep_address, new_address
from nodes.hmi.doorkeeper import Doorkeeper, Entry, Reply
from nodes.hmi.listening import DoorError, check_listen
from runtime.wire.mesh import ALL_BASES, SLOTS, page_ports

ADDRESS = Address("http://127.0.0.1:8420", 8420, "operators-token", "engineers-token")
HOST = {"host": ["127.0.0.1:8420"]}
COOKIE = {"cookie": ["other=1; msma-8420=operators-token"]}
ORIGIN = {"origin": ["http://127.0.0.1:8420"]}
Headers = dict[str, list[str]]


@pytest.fixture
def keeper(tmp_path: Path) -> Doorkeeper:
    folder = tmp_path / "page"
    (folder / "words").mkdir(parents=True)
    (folder / "index.html").write_text("<!doctype html>the page")
    (folder / "words" / "en.js").write_text("export default {}")
    (tmp_path / "secret.txt").write_text("secret")
    (folder / "link.txt").symlink_to(tmp_path / "secret.txt")
    return Doorkeeper(ADDRESS, ("127.0.0.1", "localhost"), folder, {})


def answer(keeper: Doorkeeper, path: str, headers: Headers) -> Reply:
    found = keeper.answer(path, headers)
    assert isinstance(found, Reply)
    return found


def test_the_token_in_the_address_becomes_a_cookie_that_only_our_pages_send(
    keeper: Doorkeeper,
) -> None:
    first = answer(keeper, "/?token=operators-token", HOST)
    cookie = first.headers["Set-Cookie"]
    assert first.status == 200
    assert cookie == "msma-8420=operators-token; HttpOnly; SameSite=Strict; Path=/"
    assert b"operators-token" not in first.body
    assert b'<link rel="icon" href="/icon.svg"' in first.body  # else a browser asks for another
    page = answer(keeper, "/", HOST | COOKIE)
    assert (page.status, page.body) == (200, b"<!doctype html>the page")


def test_a_page_may_load_nothing_from_elsewhere_and_be_shown_in_no_other(
    keeper: Doorkeeper,
) -> None:
    headers = answer(keeper, "/words/en.js", HOST | COOKIE).headers
    policy = headers["Content-Security-Policy"]
    assert policy.startswith("default-src 'self'; connect-src 'self' ws://127.0.0.1:8420 ")
    assert "frame-ancestors 'none'" in policy
    assert "unsafe" not in policy
    assert headers["Content-Type"] == "text/javascript; charset=utf-8"
    assert headers["X-Content-Type-Options"] == "nosniff"


@pytest.mark.parametrize("path", ["/", "/words/en.js", "/socket", "/nothing"])
def test_without_a_token_there_is_nothing(path: str, keeper: Doorkeeper) -> None:
    assert answer(keeper, path, HOST | ORIGIN).status == 403
    wrong = {"cookie": ["msma-8420=operators-toke"]}
    assert answer(keeper, path, HOST | ORIGIN | wrong).status == 403
    assert answer(keeper, "/?token=wrong", HOST).status == 403


@pytest.mark.parametrize(
    "hosts", [["evil.example:8420"], ["127.0.0.1"], ["127.0.0.1:80"], [], ["127.0.0.1:8420"] * 2]
)
def test_a_name_that_was_made_to_mean_this_computer_is_not_served(
    hosts: list[str], keeper: Doorkeeper
) -> None:
    assert answer(keeper, "/", {"host": hosts} | COOKIE).status == 421
    assert answer(keeper, "/socket", {"host": hosts} | COOKIE | ORIGIN).status == 421


@pytest.mark.parametrize(
    "origins",
    [
        [],
        ["null"],
        ["http://evil.example"],
        ["https://127.0.0.1:8420"],
        ["http://127.0.0.1:8421"],
        ["http://127.0.0.1:8420.evil.example"],
        ["http://127.0.0.1:8420", "http://evil.example"],
    ],
)
def test_the_socket_is_opened_for_our_own_pages_only(
    origins: list[str], keeper: Doorkeeper
) -> None:
    headers = HOST | COOKIE | {"origin": origins}
    assert answer(keeper, "/socket", headers).status == 403


@pytest.mark.parametrize(
    ("token", "role"), [("operators-token", "operator"), ("engineers-token", "engineer")]
)
def test_the_token_decides_on_the_role(token: str, role: str, keeper: Doorkeeper) -> None:
    headers = HOST | ORIGIN | {"cookie": [f"msma-8420={token}"]}
    assert keeper.answer("/socket", headers) == Entry(role)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    "path",
    [
        "/../secret.txt",
        "/words/../../secret.txt",
        "/%2e%2e/secret.txt",
        "//etc/passwd",
        "/..%2fsecret.txt",
        "/link.txt",
        "/words",
        "/words/",
        "http://127.0.0.1:8420/secret.txt",
        "/index.html\x00",
    ],
)
def test_there_is_no_way_out_of_the_folder(path: str, keeper: Doorkeeper) -> None:
    assert answer(keeper, path, HOST | COOKIE).status == 404


@pytest.mark.parametrize("cookie", ["=", "msma-8420", "msma-8420=\xff", '"', "a" * 5000, "[]=1"])
def test_a_cookie_that_makes_no_sense_is_no_cookie(cookie: str, keeper: Doorkeeper) -> None:
    assert answer(keeper, "/", HOST | {"cookie": [cookie]}).status == 403


@pytest.mark.parametrize(
    "path", ["", "?", "//[", "/?token=", "/?token=%00", "/?" + "token=a&" * 99]
)
def test_an_address_that_makes_no_sense_is_refused(path: str, keeper: Doorkeeper) -> None:
    assert answer(keeper, path, HOST).status in (403, 404)


def test_tokens_are_long_kept_for_their_owner_and_the_same_after_a_revival(tmp_path: Path) -> None:
    assert find_address(tmp_path) is None
    address = new_address("http://127.0.0.1:8420", 8420)
    assert len({address.operator, address.engineer}) == 2
    assert min(len(address.operator), len(address.engineer)) >= 32
    keep_address(tmp_path, address)
    (file,) = tmp_path.iterdir()
    assert file.stat().st_mode & 0o077 == 0
    assert find_address(tmp_path) == address


PEM = Path("page.pem")


@pytest.mark.parametrize(
    ("listen", "names", "certificate", "key", "wrong"),
    [
        ("0.0.0.0", (), None, None, "listen:"),
        ("192.168.1.5", (), None, None, "listen:"),
        ("::", ("robot.local",), None, None, "listen:"),
        ("0.0.0.0", (), PEM, PEM, "names:"),
        ("127.0.0.1", (), PEM, None, "key:"),
        ("192.168.1.5", (), None, PEM, "certificate:"),
    ],
)
def test_a_page_that_others_can_reach_needs_a_certificate_and_its_names(
    listen: str, names: tuple[str, ...], certificate: Path | None, key: Path | None, wrong: str
) -> None:
    with pytest.raises(DoorError, match=f"^{wrong}"):
        check_listen(listen, names, certificate, key)


def test_a_page_for_this_computer_needs_nothing() -> None:
    check_listen("127.0.0.1", (), None, None)
    check_listen("192.168.1.5", (), PEM, PEM)


def test_each_robot_s_page_has_a_port_of_its_own_that_no_process_has() -> None:
    ports = [page_ports(base)[0] for base in ALL_BASES]
    assert len(set(ports)) == len(ports)
    assert min(ports) >= ALL_BASES[-1] + SLOTS
    assert max(*ports, *page_ports(1024), *page_ports(65408)) < 32768
