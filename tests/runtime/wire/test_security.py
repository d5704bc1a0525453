"""What each name may do on the bus, and that it may do nothing else: every name on every key."""

import random
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from itertools import count
from pathlib import Path

import pytest
import zenoh

from runtime.tls.certificates import Authority, write_keys
from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.mesh import LOOPBACK, on_loopback
from runtime.wire.security import OPERATOR, Credentials, names
from tests.ports import reserve_any
from tests.runtime.conftest import wait_for

ROLES = ("plant", "goal", "joint/1", "joint/2", "platform", "hmi")
NAMES = names(ROLES)
PUTS = {
    "plant": {
        topics.HAND,
        topics.JOINTS,
        topics.PLATFORM,
        topics.KNOWN_GOAL,
        topics.OPERATOR_STATE,
    },
    "goal": {topics.GOAL},
    "joint/1": {topics.joint_command(1)},
    "joint/2": {topics.joint_command(2)},
    "platform": {topics.PLATFORM_COMMAND},
    "hmi": {topics.GOAL, topics.JOG},
    OPERATOR: {topics.GOAL},
}
CONTRACT = set().union(*PUTS.values()) | {topics.diag(role) for role in ROLES}
WILD = {
    "**",
    "arm/**",
    "arm/joint/*/cmd",
    "arm/*",
    "diag/**",
    "ctl/**",
    "alive/**",
    "arm/joint/1/**",
}
OTHERS = {
    topics.stop("joint/1"),
    topics.FAULT,
    topics.alive("joint/1", 1),
    "arm/joint/3/cmd",
    "other",
}


class House:
    """A robot whose every name has a place on the bus, all in this process."""

    def __init__(self, folder: Path, stack: ExitStack) -> None:
        self.folder, self._stack = folder, stack
        self.port, reservation = reserve_any()
        stack.enter_context(reservation)
        self.robot = f"test-{self.port}"
        self.authority = Authority(self.robot, 10)
        write_keys(folder, self.authority, [*NAMES, "stranger"], [LOOPBACK])
        self._copies = 0

    def join(self, name: str, *, copy: bool = False) -> Bus:
        """Join by the certificate of a name; an operator does as tools do."""
        mesh = on_loopback(self.port, len(ROLES))
        credentials = Credentials(self.folder, name, ROLES)
        if copy or name not in NAMES:
            place = mesh.copy_endpoints(96 + self._copies, LOOPBACK)
            self._copies += 1
        else:
            place = mesh.visitor() if name == OPERATOR else mesh.endpoints(ROLES.index(name))
        bus = Bus(self.robot, name, place, random.getrandbits(60), credentials)
        return self._stack.enter_context(bus)


@pytest.fixture(scope="module")
def house(tmp_path_factory: pytest.TempPathFactory) -> Iterator[House]:
    with ExitStack() as stack:
        yield House(tmp_path_factory.mktemp("keys"), stack)


@pytest.fixture(scope="module")
def plant(house: House) -> Bus:
    """One who receives all."""
    return house.join("plant")


@pytest.fixture(scope="module")
def members(house: House, plant: Bus) -> dict[str, Bus]:
    """A process of each name, connected to the receiver."""
    members = {name: house.join(name, copy=name != OPERATOR) for name in (*NAMES, "stranger")}
    for bus in members.values():
        wait_for(lambda bus=bus: list(bus._session.info.peers_zid()), "a connection")  # type: ignore[misc]
    return members


_CALLS = count()

Send = Callable[[str, Bus, str], None]
"""Sends a text from who has that name, on its bus."""


def arrivals(plant: Bus, members: dict[str, Bus], send: Send) -> set[str]:
    """Return what arrived at the plant as `KEY by NAME`, of what was sent by `send` over and over.

    That goes on until everybody's word has come through several times after it. What a call before
    had sent, and comes late, does not count.
    """
    call = next(_CALLS)
    texts = {name: f"{name} in call {call}" for name in members}
    senders = {text: name for name, text in texts.items()}
    got: set[tuple[str, str]] = set()
    with plant._session.declare_subscriber(
        "**", lambda sample: got.add((str(sample.key_expr), sample.payload.to_string()))
    ):
        for number in range(4):
            words = {(min(PUTS[name]), f"{texts[name]}, {number}") for name in NAMES}

            def all_heard(number: int = number, words: set[tuple[str, str]] = words) -> bool:
                for name, bus in members.items():
                    send(name, bus, texts[name])
                    if name in PUTS:
                        bus._session.put(min(PUTS[name]), f"{texts[name]}, {number}")
                time.sleep(0.02)
                return words <= got

            wait_for(all_heard, "everybody's word")
    return {f"{key} by {senders[text]}" for key, text in got if text in senders}


def test_each_name_may_put_on_its_own_keys_and_on_no_other(
    plant: Bus, members: dict[str, Bus]
) -> None:
    def send(_: str, bus: Bus, text: str) -> None:
        for key in CONTRACT | WILD | OTHERS:
            bus._session.put(key, text)
            bus._session.delete(key)

    own = {f"{key} by {name}" for name, puts in PUTS.items() for key in puts}
    own |= {f"{topics.diag(role)} by {role}" for role in ROLES}
    assert arrivals(plant, members, send) == own
    assert {key.partition(" by ")[0] for key in own} == CONTRACT


def test_a_put_through_a_declared_publisher_is_refused_too(
    plant: Bus, members: dict[str, Bus]
) -> None:
    publisher = members["joint/2"]._session.declare_publisher(topics.joint_command(1))

    def send(name: str, _: Bus, text: str) -> None:
        if name == "joint/2":
            publisher.put(text)

    assert arrivals(plant, members, send) == set()


def test_each_role_is_seen_alive_as_itself_only(plant: Bus, members: dict[str, Bus]) -> None:
    pairs = [(name, role) for name in members for role in ROLES]
    tokens = {pair: topics.alive(pair[1], number) for number, pair in enumerate(pairs)}
    with ExitStack() as stack:
        for (name, _), key in tokens.items():
            stack.enter_context(members[name]._session.liveliness().declare_token(key))
        wanted = {tokens[role, role] for role in ROLES}
        seen: set[str] = set()

        def all_seen() -> bool:
            seen.update(plant.who_is_alive())
            return seen >= wanted

        wait_for(all_seen, "all tokens")
        assert seen == wanted


def asked(bus: Bus, key: str, question: bytes = b"") -> set[str]:
    """Return who answers a question, as each says of itself."""
    answers = bus.ask(key, question, timeout=2.0)
    return {answer.data.decode() for answer in answers if answer.agreed}


QUESTIONS = [topics.stop("plant"), topics.FAULT, "ctl/**", "ctl/**/stop", "ctl/plant/*"]


@pytest.mark.parametrize("question", QUESTIONS)
def test_only_an_operator_may_give_orders(
    plant: Bus, members: dict[str, Bus], question: str
) -> None:
    asked_by: list[str] = []

    def on_query(query: zenoh.Query) -> None:
        assert query.payload is not None
        asked_by.append(query.payload.to_string())
        key = query.key_expr if "*" not in str(query.key_expr) else topics.stop("plant")
        query.reply(key, b"plant")

    with (
        plant._session.declare_queryable(topics.stop("plant"), on_query),
        plant._session.declare_queryable(topics.FAULT, on_query),
    ):
        for name, bus in members.items():
            answers = bus.ask(question, name.encode(), timeout=1.0)
            assert name == OPERATOR or not any(answer.agreed for answer in answers), name
            # all others' questions came before this one
            wait_for(lambda: asked(members[OPERATOR], question, b"operator"), "an answer")
    assert set(asked_by) == {OPERATOR}


def test_everybody_may_halt_and_the_page_and_operators_may_end_that(
    plant: Bus, members: dict[str, Bus]
) -> None:
    asked_by: dict[str, set[str]] = {topics.HALT: set(), topics.RELEASE: set(), topics.MODE: set()}
    with ExitStack() as stack:
        for key, names_of in asked_by.items():

            def on_query(query: zenoh.Query, key: str = key, by: set[str] = names_of) -> None:
                assert query.payload is not None
                by.add(query.payload.to_string())
                query.reply(key, b"plant")

            stack.enter_context(plant._session.declare_queryable(key, on_query))
        may = {topics.HALT: set(NAMES)}
        may[topics.RELEASE] = may[topics.MODE] = {"hmi", OPERATOR}

        def all_asked() -> bool:
            for name, bus in members.items():
                for key in asked_by:
                    bus.ask(key, name.encode(), timeout=1.0)
            return all(asked_by[key] >= those for key, those in may.items())

        wait_for(all_asked, "all who may to be heard")
    assert asked_by == may


def test_the_page_may_ask_the_launcher_for_a_partition_and_nobody_else_answers(
    members: dict[str, Bus],
) -> None:
    asked_by: set[str] = set()

    def on_query(query: zenoh.Query, name: str) -> None:
        assert query.payload is not None
        if name == OPERATOR:
            asked_by.add(query.payload.to_string())
        query.reply(topics.PARTITION, name)

    with ExitStack() as stack:
        for name, bus in members.items():
            reply = partial(on_query, name=name)
            stack.enter_context(bus._session.declare_queryable(topics.PARTITION, reply))
        page = members["hmi"]
        wait_for(lambda: OPERATOR in asked(page, topics.PARTITION, b"hmi"), "an answer")
        for name, bus in members.items():
            others = asked(bus, topics.PARTITION, name.encode()) - {name}  # itself it may answer
            assert others == ({OPERATOR} if name == "hmi" else set()), name
    assert asked_by <= {"hmi", OPERATOR}


def test_all_but_strangers_may_ask_how_others_are(plant: Bus, members: dict[str, Bus]) -> None:
    plant.answer(topics.diag("plant"), lambda _: b"plant")
    for name, bus in members.items():
        if name != "stranger":
            wait_for(lambda bus=bus: asked(bus, topics.EVERY_DIAG) == {"plant"}, f"{name} to hear")  # type: ignore[misc]
    assert asked(members["stranger"], topics.EVERY_DIAG) == set()


def test_each_role_answers_what_itself_is_asked_only(plant: Bus, members: dict[str, Bus]) -> None:
    with ExitStack() as stack:
        for name, bus in members.items():
            if name == OPERATOR:
                continue
            for role in ROLES[1:]:
                for key in (topics.stop(role), topics.diag(role)):

                    def on_query(query: zenoh.Query, name: str = name, key: str = key) -> None:
                        query.reply(key, name)

                    stack.enter_context(bus._session.declare_queryable(key, on_query))
        operator = members[OPERATOR]
        for role in ROLES[1:]:
            for key in (topics.stop(role), topics.diag(role)):
                said = wait_for(lambda key=key: asked(operator, key), f"an answer on {key}")  # type: ignore[misc]
                assert said == {role}, key


def test_a_stranger_hears_nothing(plant: Bus, members: dict[str, Bus]) -> None:
    rings = {name: bus.ring("**") for name, bus in members.items()}
    heard: set[str] = set()

    def all_hear() -> bool:
        plant._session.put(topics.HAND, b"here")
        for name, ring in rings.items():
            heard.update(name for _ in ring.waiting(8))
        return heard >= set(NAMES)

    wait_for(all_hear, "all to hear")
    assert heard == set(NAMES)
