"""The door: HTTP and WebSocket server of the page, on one port."""

import logging
import traceback
from collections.abc import Awaitable, Callable
from http import HTTPStatus
from typing import TYPE_CHECKING
from weakref import WeakKeyDictionary

from websockets.asyncio.server import Server, ServerConnection, serve
from websockets.datastructures import Headers
from websockets.exceptions import ConnectionClosed
from websockets.http11 import Request, Response

from nodes.hmi.doorkeeper import Doorkeeper, Entry, Reply
from nodes.hmi.protocol.values import LARGEST, Role

if TYPE_CHECKING:  # a page that encrypts nothing does without
    import ssl

_MOST_VIEWERS = 16
_ALIVE = 10.0  # [s] after which a browser that does not answer at all is gone
_TOO_LARGE = 1009  # close code of the WebSocket protocol
_OPEN = 5.0  # [s] to send a request in

Refused = Callable[[str, str], None]
"""Counts what is refused, by reason and detail."""


class Door:
    """Serves whom its keeper lets in.

    Args:
        keeper: Decides on each request.
        refused: Counts what is refused.
        meet: Called with each connection that may send and receive, and its role; to its end.
    """

    def __init__(
        self,
        keeper: Doorkeeper,
        refused: Refused,
        meet: Callable[[ServerConnection, Role], Awaitable[None]],
    ) -> None:
        self._keeper, self._refused, self._meet = keeper, refused, meet
        self._roles = WeakKeyDictionary[ServerConnection, Role]()
        self._met = 0  # how many connections are open

    def open(self, listen: str, port: int, tls: "ssl.SSLContext | None") -> Awaitable[Server]:
        """Begin to serve; `OSError` if the port cannot be had."""
        logger = logging.getLogger("msma.page")
        logger.setLevel(logging.CRITICAL)  # strangers' mistakes are counted, not printed
        return serve(
            self._handle,
            listen,
            port,
            process_request=self._process,
            compression=None,
            max_size=LARGEST,
            max_queue=4,
            open_timeout=_OPEN,
            ping_interval=_ALIVE,
            ping_timeout=_ALIVE,
            close_timeout=0.5,
            server_header=None,
            ssl=tls,
            logger=logger,
        )

    def _process(self, connection: ServerConnection, request: Request) -> Response | None:
        """Answer a request; None to go on opening the socket."""
        named: dict[str, list[str]] = {}
        for name, value in request.headers.raw_items():
            named.setdefault(name.lower(), []).append(value)
        if getattr(request, "method", "GET") != "GET":
            answer: Reply | Entry = self._keeper.text(405, "Only GET is served.\n")
        else:
            answer = self._keeper.answer(request.path, named)
        if isinstance(answer, Entry):
            if self._met < _MOST_VIEWERS:
                self._roles[connection] = answer.role
                return None
            answer = self._keeper.text(503, f"{_MOST_VIEWERS} browsers look already.\n")
        if answer.status >= 400:
            self._refused(f"HTTP {answer.status}", request.path[:100])
        headers = Headers([*answer.headers.items(), ("Connection", "close")])
        return Response(answer.status, HTTPStatus(answer.status).phrase, headers, answer.body)

    async def _handle(self, connection: ServerConnection) -> None:
        self._met += 1
        try:
            await self._meet(connection, self._roles[connection])
        except ConnectionClosed as closed:
            if closed.sent is not None and closed.sent.code == _TOO_LARGE:
                self._refused("too large", f"more than {LARGEST} bytes")
        except Exception as error:  # a defect of ours: the connection ends, and the page goes on
            self._refused(f"failed: {type(error).__name__}", traceback.format_exc())
        finally:
            self._met -= 1
