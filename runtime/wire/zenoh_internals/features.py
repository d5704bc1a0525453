"""Which of Zenoh's internals are relied on: those that are there, unless the user turns them off.

Everything works without each of them, and without all of them, if slower. The environment variable
`MSMA_ZENOH_INTERNALS` names those to use, separated by commas, or `none`; by default all.
"""

import os
from contextlib import suppress
from enum import StrEnum
from functools import cache
from pathlib import Path

import zenoh
from zenoh.handlers import Callback

from plant.errors import MsmaError

VARIABLE = "MSMA_ZENOH_INTERNALS"
_TESTED = "1.10."  # versions of Zenoh whose thread pools and log lines are known


class Internal(StrEnum):
    """One of Zenoh's internals; the value is its name in the environment variable.

    Attributes:
        DIRECT: Callbacks run in the thread that receives the message.
        GIL: Python keeps what it knows of that thread from one message to the next.
        THREADS: One thread does all of Zenoh's work, or many where hosts may vanish.
        LINGER: Connections that are given up are closed at once.
        UNREAD: Connections of which nothing is read are made anew.
        LOG: Connections that were refused are counted, from Zenoh's log.
    """

    DIRECT = "direct"
    GIL = "gil"
    THREADS = "threads"
    LINGER = "linger"
    UNREAD = "unread"
    LOG = "log"


@cache
def uses(internal: Internal) -> bool:
    """Return whether an internal is there and wanted; `MsmaError` if the variable is wrong."""
    return internal in wanted(os.environ.get(VARIABLE)) and _is_there(internal)


def wanted(value: str | None) -> frozenset[str]:
    """Return the names in the environment variable, or raise `MsmaError`."""
    if value is None:
        return frozenset(Internal)
    names = frozenset(value.replace(" ", "").split(",")) - {"none", ""}
    if unknown := ", ".join(sorted(names.difference(Internal))):
        valid = f"{', '.join(Internal)} and none"
        raise MsmaError(f"{VARIABLE}: there is no {unknown}; valid are {valid}")
    return names


def _is_there(internal: Internal) -> bool:
    if internal in (Internal.DIRECT, Internal.GIL):
        with suppress(TypeError):
            return bool(Callback(print, indirect=False))
        return False
    if internal in (Internal.LINGER, Internal.UNREAD):
        return os.path.isdir("/dev/fd")
    if internal is Internal.LOG and not hasattr(os, "memfd_create"):
        return False
    installed = Path(zenoh.__file__).parents[1]  # importlib.metadata would take 40 ms to say so
    return any(installed.glob(f"eclipse_zenoh-{_TESTED}*.dist-info"))
