"""Connections, and refusals by Zenoh before any of our code saw a message, from Zenoh's log.

Zenoh reports them only in its log, which it writes to file descriptor 1. So that becomes an unnamed
file in memory, which is read now and then: no number of attempts to connect delays this process.
Python's own output goes where it went; other output to that file is passed on.
"""

import fcntl
import os
import re
import sys
from collections.abc import Callable
from contextlib import suppress
from typing import Self

import zenoh

from runtime.wire.refusals import Refusals

REJECTED_CONNECTIONS = "(strangers)"
"""Stands for refused connections among the keys of refusals."""
ACCESS_LIST = "(access list)"
"""Stands for messages without the right to send them, over accepted connections."""

_LOGGED = (
    "off",
    "zenoh_link_tls=debug",  # has the names of peers
    "zenoh::net::routing::interceptor=trace",  # a line for each message that is dropped
    "zenoh::net::routing::interceptor::access_control=info",  # trace has allowed ones too
)
_COLOURS = re.compile(r"\x1b\[[0-9;]*m")
_LINE = re.compile(
    r"\S+Z +(?:(WARN|ERROR)|[A-Z]+) .*?"
    r"(?:(zenoh_link_tls)|zenoh::net::routing::interceptor)[a-z_:]*: (.*?)"
    r"(?: Hint: increase the system open file limit\.)?\n"  # which all failures have
)
_JOINED = re.compile(r"Accepted TLS connection on \S+: (\S+)\. Common Name: (.*)\.")
_LARGE = 1 << 20  # bytes, after which the file is emptied

_NOT_ALLOWED, _OTHER = "not allowed", "no proper connection"
_REASONS = {
    "Msg intercepted": _NOT_ALLOWED,
    "did not match any configured ACL subject": "certificate of no role here",
    "corrupt message": "not TLS",
    "sent no certificates": "no certificate",
    "certificate expired": "expired certificate",
    "certificate not valid yet": "certificate not good yet",
    "fatal alert: UnknownCA": "trusts another authority",
    "invalid peer certificate": "certificate of another authority",
}
"""Why a connection or message was refused, for people, by what the line says."""


class ConnectionLog:
    """Reads Zenoh's log within its `with` block, which begins before the first session is opened.

    Args:
        joined: Called with name and address of each peer that connected with a valid certificate.
    """

    def __init__(self, refusals: Refusals, joined: Callable[[str, str], None]) -> None:
        self._refusals, self._joined = refusals, joined
        self._all = "RUST_LOG" in os.environ  # the user wants to read it
        self._log, self._read = os.memfd_create("zenoh-log"), 0
        fcntl.fcntl(self._log, fcntl.F_SETFL, os.O_APPEND)

    def __enter__(self) -> Self:
        self._stdout = sys.stdout
        self._stdout.flush()
        encoding, errors = self._stdout.encoding, self._stdout.errors
        sys.stdout = self._out = os.fdopen(os.dup(1), "w", encoding=encoding, errors=errors)
        os.dup2(self._log, 1)
        zenoh.init_log_from_env_or(",".join(_LOGGED))
        return self

    def look(self) -> None:
        """Count what was logged since the last look, and pass on what else was written."""
        data = os.pread(self._log, os.fstat(self._log).st_size - self._read, self._read)
        lines = data[: data.rfind(b"\n") + 1].splitlines(keepends=True)
        self._read += sum(map(len, lines))
        self._pass_on(b"".join(line for line in lines if not self._counts(line) or self._all))
        if self._read > _LARGE:
            os.ftruncate(self._log, 0)  # what was written since the last read goes uncounted
            self._read = 0

    def _counts(self, line: bytes) -> bool:
        """Count what a line is about, and tell whether it is one of those that were asked for."""
        match = _LINE.fullmatch(_COLOURS.sub("", line.decode(errors="replace")))
        if match is None:
            return False
        failed, of_link, said = match.groups()
        if of_link and not failed:
            if joined := _JOINED.fullmatch(said):
                self._joined(joined[2], joined[1])
            return True
        why = next((why for sign, why in _REASONS.items() if sign in said), _OTHER)
        if of_link or why != _OTHER:
            key = ACCESS_LIST if why == _NOT_ALLOWED else REJECTED_CONNECTIONS
            self._refusals.count(key, why, said)
        return True

    def _pass_on(self, data: bytes) -> None:
        with suppress(OSError):  # the reader has gone
            self._out.buffer.write(data)
            self._out.flush()

    def __exit__(self, *_: object) -> None:
        """Look for the last time, and put the standard output back."""
        self._pass_on(b"")
        os.dup2(self._out.fileno(), 1)
        self.look()
        self._pass_on(os.pread(self._log, _LARGE, self._read))
        sys.stdout = self._stdout
        with suppress(OSError):
            self._out.close()
        os.close(self._log)
