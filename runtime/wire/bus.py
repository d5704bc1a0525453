"""The bus: the one way to the other processes. A thin edge over a Zenoh session.

Nothing here blocks a sender: what does not get through is dropped, for the next one is coming.
"""

import math
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager, suppress
from queue import Empty, SimpleQueue
from threading import Thread
from threading import enumerate as enumerate_threads
from typing import NamedTuple

import zenoh
from zenoh.handlers import Handler, RingChannel

from plant.errors import MsmaError
from runtime.wire import topics
from runtime.wire.mesh import Endpoints
from runtime.wire.messages import Message
from runtime.wire.packing import stamped
from runtime.wire.samples import Sample, data_of, sample_of
from runtime.wire.security import Credentials
from runtime.wire.session import config
from runtime.wire.topics import Topic
from runtime.wire.zenoh_internals.callbacks import CallbackSubscriber, SampleQueue, direct_callback
from runtime.wire.zenoh_internals.transport import Connections

_LINGER = 0.1  # [s] that an answer has to leave before the bus is closed: closing drops what waits
_CLOSES = 0.5  # [s] that closing may take: Zenoh waits for attempts to connect to whoever hangs
_CLOSING = "closing a bus"  # the thread that does that
_BY_ZENOH = zenoh.Encoding.ZENOH_STRING  # of the error that it makes up for whoever is late
_LATER = 0.5  # [s] after which a query that Zenoh has not given up by itself is given up


class BusError(MsmaError, ConnectionError):
    """The bus cannot be joined, or is closed."""


class Answer(NamedTuple):
    """What a process answered to a query: its key, the bytes, and whether it agreed."""

    key: str
    data: bytes
    agreed: bool


class Publisher:
    """Sends messages on one key, each stamped with it, the incarnation and a number counting up."""

    def __init__(self, publisher: zenoh.Publisher, key: str, incarnation: int) -> None:
        self._publisher, self._key = publisher, key
        self._incarnation = incarnation
        self._n = 0

    def send(self, message: Message) -> None:
        """Send and do not wait."""
        self._put(self._packed(message))

    def _packed(self, message: Message) -> bytes:
        self._n += 1
        return stamped(message, self._incarnation, self._n, self._key)

    def _put(self, packed: bytes) -> None:
        try:
            self._publisher.put(packed)
        except zenoh.ZError as error:
            raise BusError(f"the bus is closed: {error}") from None


def is_closing() -> bool:
    """Tell whether a bus still closes that `Bus.close` has given up.

    Should that end while Python does, it aborts the process: Zenoh's code cannot be unwound.
    """
    return any(thread.name == _CLOSING for thread in enumerate_threads())


def send_together(messages: Sequence[tuple[Publisher, Message]]) -> None:
    """Send several, the last one on an express publisher, so that all go in one packet.

    All are packed first, or the first ones might go alone.
    """
    packed = [(publisher, publisher._packed(message)) for publisher, message in messages]
    for publisher, data in packed:
        publisher._put(data)


class RingSubscriber:
    """The last few messages on a key expression, for a loop that waits for them."""

    def __init__(self, subscriber: zenoh.Subscriber[Handler[zenoh.Sample]]) -> None:
        self._subscriber = subscriber

    def recv(self) -> Sample:
        """Wait for the oldest of them; `BusError` once the bus is closed."""
        try:
            sample = self._subscriber.recv()
        except zenoh.ZError as error:
            raise BusError(f"the bus is closed: {error}") from None
        return sample_of(sample)

    def waiting(self, most: int) -> Iterator[Sample]:
        """Yield those that wait already, at most that many, so that a flood has an end."""
        for _ in range(most):
            try:
                sample = self._subscriber.try_recv()
            except zenoh.ZError as error:
                raise BusError(f"the bus is closed: {error}") from None
            if sample is None:
                return
            yield sample_of(sample)


class Bus(AbstractContextManager["Bus"]):
    """A process's connection to its robot's bus; open within its `with` block.

    Args:
        robot: Name of the robot, the Zenoh namespace, which separates robots; None to see all.
        place: Where it listens, and to whom it connects.
        incarnation: The random number of this process.
        credentials: Its certificate, on a robot with `security`.

    Attributes:
        connections: To be looked at about four times a second, by whoever stays.
    """

    def __init__(
        self,
        robot: str | None,
        role: str,
        place: Endpoints,
        incarnation: int,
        credentials: Credentials | None = None,
    ) -> None:
        self.incarnation = incarnation
        self._named = robot is not None  # else its keys begin with the robot's name
        try:
            self._session = zenoh.open(config(robot, place, credentials))
        except zenoh.ZError as error:
            raise BusError(_why(robot, role, place, str(error))) from None
        self.connections = Connections(place.dialled_ports)
        self._asked = -math.inf  # when the last query came [s, monotonic]

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Leave the bus: a loop that waits for messages ends with `BusError`."""
        time.sleep(max(self._asked + _LINGER - time.monotonic(), 0.0))
        closing = Thread(target=self._close_session, name=_CLOSING, daemon=True)
        closing.start()
        closing.join(_CLOSES)

    def _close_session(self) -> None:
        with suppress(zenoh.ZError):  # it gives closing up, after some 10 s
            self._session.close()  # type: ignore[no-untyped-call]

    def publisher(self, key: str, topic: Topic | None = None) -> Publisher:
        """Return what publishes on one key, as its `topic` says: by default the standard one."""
        topic = topic or topics.STANDARD.topic_of(key)
        urgent, express = (topic.urgent, topic.express) if topic else (True, True)
        publisher = self._session.declare_publisher(
            key,
            congestion_control=zenoh.CongestionControl.DROP,
            priority=zenoh.Priority.REAL_TIME if urgent else zenoh.Priority.DATA_LOW,
            express=express,
        )
        return Publisher(publisher, key, self.incarnation)

    def ring(self, key: str, depth: int = 8) -> RingSubscriber:
        """Return the last `depth` messages on a key expression, for a loop to wait for."""
        return RingSubscriber(self._session.declare_subscriber(key, RingChannel(depth)))

    def sample_queue(self, *expressions: str) -> SampleQueue:
        """Return the last messages that come on some key expressions.

        The thread that receives a message puts it there: that saves a change of threads.
        """
        sample_queue = SampleQueue()
        for expression in expressions:
            self._session.declare_subscriber(expression, direct_callback(sample_queue.put))
        return sample_queue

    def on_sample(
        self,
        key: str,
        react: Callable[[Sequence[Sample], float], None],
        silence: float | None = None,
        afterwards: Callable[[], None] = lambda: None,
    ) -> CallbackSubscriber:
        """Return what reacts to each message on a key, and to silence, once it runs."""
        on_sample = CallbackSubscriber(key, react, silence, afterwards)
        handler = direct_callback(on_sample.put, drop=on_sample.close)
        self._session.declare_subscriber(key, handler)
        return on_sample

    def subscribe(self, key: str, take: Callable[[str, bytes], None]) -> None:
        """Call `take` with key and bytes of each message, in a thread of the bus."""
        self._session.declare_subscriber(key, lambda sample: take(*sample_of(sample)))

    def announce(self, role: str) -> None:
        """Be seen alive as long as the process lives and the bus is open."""
        key = topics.alive(role, self.incarnation)
        self._token = self._session.liveliness().declare_token(key)

    def watch_alive(self, react: Callable[[str, bool], None]) -> None:
        """Call `react` with each token's key and whether it is there, first for all there are."""
        self._session.liveliness().declare_subscriber(
            topics.EVERYBODY_ALIVE,
            lambda sample: react(str(sample.key_expr), sample.kind == zenoh.SampleKind.PUT),
            history=True,
        )

    @property
    def links(self) -> int:
        """How many other processes it is connected to."""
        return len(list(self._session.info.peers_zid()))

    def who_is_alive(self, timeout: float = 1.0) -> list[str]:
        """Return the keys of all tokens there are; waits [s] only for whom it has lost."""
        replies = _replies(self._session.liveliness().get, topics.EVERYBODY_ALIVE, timeout)
        return [str(reply.ok.key_expr) for reply in replies if reply.ok is not None]

    def answer(self, key: str, reply: Callable[[bytes], bytes]) -> None:
        """Answer each query on `key` by what `reply` returns, or by its error's message.

        One that says that it was asked on another key is not acted on, see `packing.unpack`.
        """

        def on_query(query: zenoh.Query) -> None:
            self._asked = time.monotonic()
            question = b"" if query.payload is None else data_of(query.payload)
            try:
                if not _meant_for(query.attachment, key):
                    raise BusError("it was asked on another key")
                query.reply(key, reply(question), attachment=key)
            except MsmaError as error:
                query.reply_err(str(error).encode())

        self._session.declare_queryable(key, on_query)

    def ask(self, key: str, question: bytes = b"", timeout: float = 1.0) -> list[Answer]:
        """Query all that answer on a key expression; wait at most `timeout` [s]."""
        return list(self.answers(key, question, timeout))

    def answers(self, key: str, question: bytes = b"", timeout: float = 1.0) -> Iterator[Answer]:
        """Yield each answer as it comes, for whom the first is enough: see `ask`."""
        replies = _replies(
            self._session.get,
            key,
            timeout,
            payload=question,
            attachment=key if self._named else None,
            target=zenoh.QueryTarget.ALL,
            consolidation=zenoh.ConsolidationMode.NONE,  # copies answer on the same key
        )
        for reply in replies:
            if reply.ok is not None:
                answered = str(reply.ok.key_expr)
                if not self._named or _meant_for(reply.ok.attachment, answered):
                    yield Answer(answered, data_of(reply.ok.payload), True)
            elif reply.err is not None and reply.err.encoding != _BY_ZENOH:
                yield Answer(key, data_of(reply.err.payload), False)


def _meant_for(attachment: zenoh.ZBytes | None, key: str) -> bool:
    """Return whether a query or an answer was sent on a key, as far as it says on which."""
    if attachment is None:
        return True
    try:
        return bool(zenoh.KeyExpr(data_of(attachment).decode()).intersects(zenoh.KeyExpr(key)))
    except (zenoh.ZError, UnicodeDecodeError):
        return False


def _replies(
    get: Callable[..., object], key: str, timeout: float, **options: object
) -> Iterator[zenoh.Reply]:
    """Yield the replies to a query until all are in, or hardly longer than `timeout` [s].

    Zenoh itself should time out. But it does so in the thread that does all of its work, so not
    while that one is blocked, such as by far too many peers.
    """
    replies: SimpleQueue[zenoh.Reply | None] = SimpleQueue()
    handler = direct_callback(replies.put, drop=lambda: replies.put(None))
    get(key, handler, timeout=timeout, **options)
    deadline = time.monotonic() + timeout + _LATER
    with suppress(Empty):
        while (reply := replies.get(timeout=max(deadline - time.monotonic(), 0))) is not None:
            yield reply


def _why(robot: str | None, role: str, place: Endpoints, error: str) -> str:
    host, port = place.listen
    if "assign requested address" in error:
        return (
            f"{role} of {robot} runs on another machine: this one does not have address {host}. "
            f"`msma launch` starts a host's share by `--host`, and all hosts' by `--ssh`"
        )
    what = f"{role} cannot join the bus of {robot}"
    if "in use" not in error:
        return f"{what}: {error}"
    return (
        f"{what}: port {port} of {host} is taken. Perhaps {role} runs already (see `msma status "
        f"--robot {robot}`): stop it first with `msma stop`, or start this one beside it with "
        f"`--copy`. If another program has the port, set `port` in the deployment file, or name "
        f"the robot otherwise"
    )
