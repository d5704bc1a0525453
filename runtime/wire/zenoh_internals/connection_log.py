"""Connections, and refusals by Zenoh before any of our code saw a message, from Zenoh's log.

Zenoh reports them only in its log, which it writes to file descriptor 1. So that becomes an unnamed
file, which is read now and then: no number of attempts to connect delays this process, and no file
remains. Python's own output goes where it went; other output to that file is passed on.
"""

import fcntl
import os
import re
import sys
from collections.abc import Callable
from contextlib import suppress
from enum import StrEnum
from typing import Self

import zenoh

from runtime.wire.refusals import Refusals
from runtime.wire.zenoh_internals.features import Internal, uses

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
_COLOURS = re.compile(rb"\x1b\[[0-9;]*m")
_LINE = re.compile(rb"\S+Z +([A-Z]+) .*?(zenoh[a-z_:]*): (.*)")
_JOINED = re.compile(rb"Accepted TLS connection on \S+: (\S+)\. Common Name: (.*)\.")
_LINKS, _RULES = b"zenoh_link_tls", b"zenoh::net::routing::interceptor"
_OURS = (_LINKS, _RULES)
_HINT = " Hint: increase the system open file limit."  # which it adds to all failures
_LARGE = 1 << 20  # bytes, after which the file is emptied


class Rejection(StrEnum):
    """Why a connection or message was refused; the value is for people."""

    NOT_TLS = "not TLS"
    NO_CERTIFICATE = "no certificate"
    EXPIRED = "expired certificate"
    TOO_EARLY = "certificate not good yet"
    OTHER_AUTHORITY = "certificate of another authority"
    DISTRUST = "trusts another authority"
    NO_ROLE = "certificate of no role here"
    NOT_ALLOWED = "not allowed"
    OTHER = "no proper connection"


_OF_RULES = (
    (b"Msg intercepted", Rejection.NOT_ALLOWED),
    (b"did not match any configured ACL subject", Rejection.NO_ROLE),
)
_OF_LINKS = (
    (b"corrupt message", Rejection.NOT_TLS),
    (b"sent no certificates", Rejection.NO_CERTIFICATE),
    (b"certificate expired", Rejection.EXPIRED),
    (b"certificate not valid yet", Rejection.TOO_EARLY),
    (b"fatal alert: UnknownCA", Rejection.DISTRUST),
    (b"invalid peer certificate", Rejection.OTHER_AUTHORITY),
)


class ConnectionLog:
    """Reads Zenoh's log within its `with` block, which begins before the first session is opened.

    Args:
        refusals: Counts the refusals.
        joined: Called with name and address of each peer that connected with a valid certificate.
    """

    def __init__(self, refusals: Refusals, joined: Callable[[str, str], None]) -> None:
        self._on = uses(Internal.LOG)
        if not self._on:
            return
        self._refusals, self._joined = refusals, joined
        self._all = "RUST_LOG" in os.environ  # the user wants to read it
        self._rest = b""
        self._read = 0
        self._stdout = sys.stdout
        self._stdout.flush()
        self._out = os.dup(1)
        encoding, errors = self._stdout.encoding, self._stdout.errors
        sys.stdout = os.fdopen(os.dup(1), "w", encoding=encoding, errors=errors)
        self._log = _unnamed_file()
        os.dup2(self._log, 1)
        zenoh.init_log_from_env_or(",".join(_LOGGED))

    def __enter__(self) -> Self:
        return self

    def look(self) -> None:
        """Count what was logged since the last look, and pass on what else was written."""
        if not self._on:
            return
        others = []
        while data := os.pread(self._log, _LARGE, self._read):
            self._read += len(data)
            *lines, self._rest = (self._rest + data).split(b"\n")
            for line in lines:
                match = _LINE.fullmatch(_COLOURS.sub(b"", line))
                if match is None or self._all or not match[2].startswith(_OURS):
                    others.append(line + b"\n")
                if match is None:
                    continue
                if joined := _JOINED.fullmatch(match[3]):
                    self._joined(*(part.decode(errors="replace") for part in joined.groups()[::-1]))
                elif why := _rejection(*match.groups()):
                    key = ACCESS_LIST if why is Rejection.NOT_ALLOWED else REJECTED_CONNECTIONS
                    detail = match[3].decode(errors="replace").removesuffix(_HINT)
                    self._refusals.count(key, why, detail)
        if self._read > _LARGE:
            os.ftruncate(self._log, 0)  # what was written since the last read goes uncounted
            self._read = 0
        self._pass_on(b"".join(others))

    def _pass_on(self, data: bytes) -> None:
        with suppress(OSError):  # the reader has gone
            while data:
                data = data[os.write(self._out, data) :]

    def __exit__(self, *_: object) -> None:
        """Look for the last time, and put the standard output back."""
        if not self._on:
            return
        with suppress(OSError):
            sys.stdout.close()
        sys.stdout = self._stdout
        os.dup2(self._out, 1)
        self.look()
        self._pass_on(self._rest)
        os.close(self._out)
        os.close(self._log)


def _rejection(level: bytes, target: bytes, said: bytes) -> Rejection | None:
    """Return the reason in a line of Zenoh's log; None if it is about something else."""
    if target.startswith(_LINKS) and level in (b"WARN", b"ERROR"):
        return next((why for sign, why in _OF_LINKS if sign in said), Rejection.OTHER)
    if target.startswith(_RULES):
        return next((why for sign, why in _OF_RULES if sign in said), None)
    return None


def _unnamed_file() -> int:
    """Return a file that appends, in memory where the system has that."""
    if not hasattr(os, "memfd_create"):
        import tempfile  # which imports as much again as all that this module does

        with tempfile.TemporaryFile("ab") as file:
            return os.dup(file.fileno())
    memory = os.memfd_create("zenoh-log")
    fcntl.fcntl(memory, fcntl.F_SETFL, os.O_APPEND)
    return memory
