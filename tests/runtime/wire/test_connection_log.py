"""ConnectionLog of every kind, on every key, at a launched robot that is closed to them."""

import random
import re
import signal
import socket
import ssl
import subprocess
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack, suppress
from datetime import UTC, datetime, timedelta
from functools import partial
from pathlib import Path

from runtime.tls.certificates import Authority, write_keys
from runtime.watching.local import diags
from runtime.wire import topics
from runtime.wire.bus import Bus, RingSubscriber
from runtime.wire.mesh import FIRST_COPY, LOOPBACK
from runtime.wire.messages import Message
from runtime.wire.packing import pack, unpack
from runtime.wire.refusals import MessageError
from runtime.wire.security import OPERATOR, Credentials, names
from runtime.wire.zenoh_internals.connection_log import ACCESS_LIST, REJECTED_CONNECTIONS
from tests.runtime.conftest import FOLLOWS, RUN_DEADLINE, TOLERANCE, Robot, wait_for
from tests.runtime.test_launch import ROLES
from tests.runtime.wire.test_flood import samples

PATH = 24.0
"""Plant time at which the goal comes to stand [s]; the run goes on until all has been looked at."""
BY = 77
"""The incarnation that all strangers go by."""
WILD = ("**", "arm/**", "arm/*", "arm/joint/*/cmd", "diag/**")
TOKENS = {topics.alive(role, BY) for role in ("plant", "joint/1", "joint/2")}
INSIDER = "joint/2"
Tables = Mapping[str, Mapping[str, Mapping[str, int]]]
"""Role to key to reason to how many were refused."""


def attack(bus: Bus, spared: set[str], count: int) -> None:
    """Say all that a robot can be told, give every order and answer in place of others."""
    for key in (topics.stop("**"), topics.stop("plant"), topics.FAULT):
        answers = bus.ask(key, b"joint/1:locked", timeout=0.5)
        assert not any(answer.agreed for answer in answers)
    for token in TOKENS - spared:
        bus._session.liveliness().declare_token(token)
    for key in (topics.FAULT, topics.stop("joint/1"), topics.diag("plant"), topics.diag("joint/1")):
        bus.answer(key, lambda _: b"stranger")
    speak(bus, spared, count)


def speak(bus: Bus, spared: set[str], count: int) -> None:
    """Say all that a robot can be told."""
    publisher = bus._session.declare_publisher(topics.joint_command(1))
    for n in range(count):
        messages: dict[str, Message] = samples(n)
        for key in set(messages) - spared:
            bus._session.put(key, pack(messages[key]))
        publisher.put(pack(messages[topics.joint_command(1)]))
        for key in (*WILD, topics.diag("plant"), topics.diag("joint/1")):
            bus._session.put(key, pack(messages[topics.joint_command(1)]))
        time.sleep(0.01)


class Siege:
    """A run, all strangers at once in the midst of it, and what was to be seen of them."""

    def __init__(self, robot: Robot, folder: Path) -> None:
        self.robot, self._folder = robot, folder
        self._slot = FIRST_COPY
        authority = Authority(robot.name, 10)
        self.keys = folder / "keys"
        write_keys(self.keys, authority, [*names(ROLES), "nobody"], [LOOPBACK])
        options = ("--speed", "1.5", "--duration", "10min", "--set", f"goal.duration={PATH:g} s")
        more = ("--set", f"security.keys={self.keys}")
        launcher = robot.launch(*options, *more, file="arph-secure.yaml")
        robot.until(1.0)
        self._mesh = robot.mesh
        with ExitStack() as self._stack:  # a busy machine takes long to connect them all
            self._besiege(authority)
        robot.until(PATH + 1.0)
        self.stopped = time.time()
        launcher.send_signal(signal.SIGINT)
        self.out, self.err = launcher.communicate(timeout=RUN_DEADLINE)
        self.code = launcher.returncode

    def _besiege(self, authority: Authority) -> None:
        now = datetime.now(UTC)
        expired = authority.issue("joint/1", [LOOPBACK], now - timedelta(9), now - timedelta(1))
        other = Authority(self.robot.name, 10).issue("joint/1", [LOOPBACK])
        self.outsiders = {
            "without TLS": self._join(None),
            "expired": self._join(self._with("expired", expired)),
            "of another authority": self._join(self._with("other", other)),
            "of no role": self._join(Credentials(self.keys, "nobody", tuple(ROLES))),
        }
        self._knock_without_a_certificate(authority)
        insider = self._join(Credentials(self.keys, INSIDER, tuple(ROLES)))
        rings = {kind: bus.ring("**") for kind, bus in self.outsiders.items()}
        operator = Credentials(self.keys, OPERATOR, tuple(ROLES))
        observer = self._bus(self._mesh.visitor(), operator)
        seen = observer.sample_queue("**")
        for bus in self.outsiders.values():
            attack(bus, set(), 20)
        spared = {*topics.STANDARD.keys_of(INSIDER), topics.alive(INSIDER, BY)}
        attack(insider, spared, 50)
        self.seen = [(arrival.key, arrival.data) for _, arrival in seen.take()]
        self.alive = observer.who_is_alive()
        self.overheard = {kind: _strange(kind, ring) for kind, ring in rings.items()}
        again = partial(self._knock_without_a_certificate, authority)
        self.refused = self._all_counted(observer, partial(speak, insider, spared, 5), again)
        self.told = wait_for(lambda: diags(observer), "an answer")

    def _with(self, name: str, pair: tuple[str, str]) -> Credentials:
        """Return credentials of joint/1 with that pair of keys, and the robot's authority."""
        folder = self._folder / name
        folder.mkdir()
        credentials = Credentials(folder, "joint/1", tuple(ROLES))
        credentials.certificate.write_text(pair[0])
        credentials.private_key.write_text(pair[1])
        credentials.authority.write_bytes((self.keys / "ca.pem").read_bytes())
        return credentials

    def _join(self, credentials: Credentials | None) -> Bus:
        """Take the next seat of a copy, which tools dial as well."""
        place = self._mesh.copy_endpoints(self._slot, LOOPBACK)
        self._slot += 1
        return self._bus(place, credentials)

    def _bus(self, place, credentials: Credentials | None) -> Bus:  # type: ignore[no-untyped-def]
        bus = Bus(self.robot.name, "a stranger", place, random.getrandbits(60), credentials)
        return self._stack.enter_context(bus)

    def _knock_without_a_certificate(self, authority: Authority) -> None:
        context = ssl.create_default_context(cadata=authority.certificate)
        for slot in range(len(ROLES)):
            address = (LOOPBACK, self._mesh.base + slot)
            with (
                suppress(OSError),
                socket.create_connection(address, timeout=5.0) as link,
                context.wrap_socket(link, server_hostname=LOOPBACK) as secured,
            ):
                secured.recv(1)

    def _all_counted(self, observer: Bus, *again: Callable[[], object]) -> Tables:
        """Return what each role has refused, once it has counted all kinds.

        One that a busy machine held up was not connected to: so they do it `again`.
        """
        wanted = {(REJECTED_CONNECTIONS, reason) for reason in REASONS} | {
            (ACCESS_LIST, "not allowed")
        }

        def look() -> Tables:
            tables: Tables = {diag.role: diag.refused for diag in diags(observer)}
            counted = [
                {
                    (key, reason)
                    for key, reasons in table.items()
                    for reason, number in reasons.items()
                    if key != ACCESS_LIST or number > 10
                }
                for table in tables.values()
            ]
            if len(tables) == len(ROLES) and all(map(wanted.__le__, counted)):
                return tables
            for one in again:
                one()
            return {}

        return wait_for(look, "all strangers to be counted by all")


REASONS = (
    "not TLS",
    "no certificate",
    "expired certificate",
    "certificate of another authority",
    "certificate of no role here",
)


def _strange(kind: str, ring: RingSubscriber) -> list[str]:
    """Return what an outsider has heard that he did not say himself."""
    return [one.key for one in ring.waiting(8) if not _is_a_stranger_s(one.key, one.data)]


def _is_a_stranger_s(key: str, data: bytes) -> bool:
    topic = topics.STANDARD.topic_of(key)
    if topic is None:
        return True
    with suppress(MessageError):
        return unpack(topic.message, data).by == BY
    return True


def the_run_reaches_its_goal(siege: Siege) -> None:
    assert siege.code == 130, siege.out + siege.err  # by our own interrupt, not by an order
    assert siege.robot.error_at_the_end < TOLERANCE
    worst = siege.robot.summary["evaluation"]["tracking"]["worst"]
    assert worst < max(FOLLOWS, siege.robot.follows)


def every_process_counts_who_cannot_connect_by_reason(siege: Siege) -> None:
    for role, table in siege.refused.items():
        assert all(table[REJECTED_CONNECTIONS][reason] for reason in REASONS), role
    assert {*siege.refused} == {*ROLES}


def every_process_counts_what_a_name_is_not_allowed(siege: Siege) -> None:
    assert all(table[ACCESS_LIST]["not allowed"] > 10 for table in siege.refused.values())


def nothing_of_it_comes_to_be_judged_as_a_message(siege: Siege) -> None:
    for role, table in siege.refused.items():
        assert set(table) == {REJECTED_CONNECTIONS, ACCESS_LIST}, role


def a_tool_hears_nothing_that_a_stranger_says(siege: Siege) -> None:
    assert {key for key, _ in siege.seen} >= {topics.HAND, topics.JOINTS, topics.GOAL}
    assert [key for key, data in siege.seen if _is_a_stranger_s(key, data)] == []


def no_outsider_hears_anything(siege: Siege) -> None:
    assert siege.overheard == {kind: [] for kind in siege.outsiders}


def nobody_is_seen_alive_or_answers_in_place_of_another(siege: Siege) -> None:
    assert not TOKENS & set(siege.alive)
    assert {diag.pid for diag in siege.told} <= set(map(siege.robot.pid, ROLES))
    assert siege.told


def no_order_of_a_stranger_is_carried_out(siege: Siege) -> None:
    assert siege.robot.log("plant", "fault") == []
    for role in ROLES:
        assert [end["wall"] > siege.stopped for end in siege.robot.log(role, "end")] == [True], role


def the_logs_and_the_summary_tell_of_it(siege: Siege) -> None:
    for role in ROLES:
        told = {(line["key"], line["reason"]) for line in siege.robot.log(role, "refused")}
        assert told >= {(REJECTED_CONNECTIONS, reason) for reason in REASONS}
        came = [line["name"] for line in siege.robot.log(role, "joined")]
        assert INSIDER in came
        assert "nobody" in came
    assert siege.robot.log("launcher", "refused")
    plant = siege.robot.summary["processes"][0]
    assert plant["refused"][ACCESS_LIST]["not allowed"] > 10
    assert "not allowed" in siege.out


def no_process_and_no_file_is_left(siege: Siege) -> None:
    assert siege.robot.processes() == {}
    assert [path.name for path in siege.robot.folder.iterdir()] == ["runs"]
    assert len(list((siege.robot.folder / "runs").iterdir())) == 1


def test_strangers_neither_move_a_robot_nor_hear_it_and_are_told_of(
    robot: Robot, tmp_path: Path
) -> None:
    """All of it is looked for in one run: it takes long, and workers would each have their own."""
    siege = Siege(robot, tmp_path)
    the_run_reaches_its_goal(siege)
    every_process_counts_who_cannot_connect_by_reason(siege)
    every_process_counts_what_a_name_is_not_allowed(siege)
    nothing_of_it_comes_to_be_judged_as_a_message(siege)
    a_tool_hears_nothing_that_a_stranger_says(siege)
    no_outsider_hears_anything(siege)
    nobody_is_seen_alive_or_answers_in_place_of_another(siege)
    no_order_of_a_stranger_is_carried_out(siege)
    the_logs_and_the_summary_tell_of_it(siege)
    no_process_and_no_file_is_left(siege)


def test_a_robot_that_is_open_obeys_the_same_stranger(robot: Robot) -> None:
    launcher = robot.launch("--duration", "16s", "--speed", "2")
    robot.until(0.5)
    with Bus(robot.name, "a stranger", robot.mesh.copy_endpoints(FIRST_COPY, LOOPBACK), 1) as bus:
        n = 0
        while robot.t < 14.0 and launcher.poll() is None:
            n += 1
            for key, message in samples(n).items():
                bus._session.put(key, pack(message))
            time.sleep(0.02)
    launcher.communicate(timeout=RUN_DEADLINE)
    assert robot.summary["evaluation"]["tracking"]["worst"] > 0.1


OF_TOOLS = re.compile(r": \d+ (not TLS|no proper connection)$")
"""What is refused of tools that look for the robots on this machine, which may be other tests', and
of tools that end while a busy process has yet to answer them."""


def tool(robot: Robot) -> Callable[..., subprocess.CompletedProcess[str]]:
    """Return what calls `msma` for a robot by the deployment of its run."""
    file = str(robot.run_folder / "deployment.yaml")
    return lambda verb, *arguments: robot.msma(verb, *arguments, "--file", file)


def test_all_tools_work_by_the_operator_s_certificate(robot: Robot, tmp_path: Path) -> None:
    where = tmp_path / "keys"
    write_keys(where, Authority(robot.name, 10), names(ROLES), [LOOPBACK])
    launcher = robot.launch(
        *("--duration", "10min", "--set", f"security.keys={where}"), file="arph-secure.yaml"
    )
    robot.until(0.3)
    msma = tool(robot)
    of = ("--file", str(robot.run_folder / "deployment.yaml"))
    robot.working("fault", "joint/4:weak=0.5", *of, says="joint/4:weak=0.5: ok\n")
    robot.working("echo", "goal", "-n", "1", *of, says='"key": "goal"')
    robot.working("hz", "arm/joint/*/cmd", "--seconds", "0.3", *of, says="arm/joint/1/cmd: ")
    robot.working("kill", "joint/2", *of, says="killed joint/2")
    robot.working("revive", "joint/2", *of)

    def all_shown() -> list[str] | None:
        """Return the lines of status once all have been heard: a busy machine connects slowly."""
        lines: list[str] = msma("status").stdout.splitlines()
        shown = [line.split()[0] for line in lines[2 : 2 + len(ROLES)]]
        return lines if shown == ROLES else None

    status = wait_for(all_shown, "all roles")
    refused = [line for line in status if REJECTED_CONNECTIONS in line]
    assert [line for line in refused if not OF_TOOLS.search(line)] == []
    wait_for(lambda: "runs already" in msma("doctor").stdout, "the doctor to find it")
    robot.working("status")  # without the file: this user has started the run
    wait_for(lambda: msma("stop").returncode == 0 or launcher.poll() is not None, "the stop")
    launcher.communicate(timeout=RUN_DEADLINE)
    assert robot.processes() == {}
