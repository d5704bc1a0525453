"""Importing what can do without OpenSSL, without it: for a page that encrypts nothing."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec

_OPENSSL = ("ssl", "_ssl", "_hashlib")


@contextmanager
def without_openssl() -> Iterator[None]:
    """Have what is imported meanwhile not find OpenSSL, which takes 5 MB of a process.

    Python may be built without it, so its library can do without: asyncio then has no TLS, and
    hashlib has SHA-1, by which a WebSocket is opened, from code of its own. Where Python has been
    built without that code, OpenSSL is found. What is imported later finds it as ever.
    """
    names = () if find_spec("_sha1") is None else _OPENSSL
    hidden = [name for name in names if name not in sys.modules]
    sys.modules.update(dict.fromkeys(hidden))  # type: ignore[arg-type]  # None: it is not there
    try:
        yield
    finally:
        for name in hidden:
            del sys.modules[name]
