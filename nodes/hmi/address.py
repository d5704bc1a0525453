"""Where a run's page is, and its two tokens: made once a run, so that a revived page has the same.

They are in a file of the run's folder that only its owner can read; whoever starts the run prints
the address from there.
"""

import json
import os
import secrets
from pathlib import Path
from typing import NamedTuple

from runtime.atomic import write_atomically

FILE = "page.json"
_BYTES = 24  # of a token: 192 bits, which nobody guesses


class Address(NamedTuple):
    """Where the page is served, and what is needed to see it.

    Attributes:
        origin: Such as http://127.0.0.1:8420.
        port: The port, which is part of the cookie's name.
        operator: Token of who drives.
        engineer: Token of who may also break things.
    """

    origin: str
    port: int
    operator: str
    engineer: str

    @property
    def page(self) -> str:
        """The address that opens the page for an operator."""
        return f"{self.origin}/?token={self.operator}"

    @property
    def engineers_page(self) -> str:
        """The address that opens it for an engineer."""
        return f"{self.origin}/?token={self.engineer}"


def new_address(origin: str, port: int) -> Address:
    """Return an address with tokens of its own."""
    return Address(origin, port, secrets.token_urlsafe(_BYTES), secrets.token_urlsafe(_BYTES))


def find_address(run: Path) -> Address | None:
    """Return the address of the page of a run; None if there is none yet."""
    try:
        found = json.loads((run / FILE).read_text())
        return Address(**{name: found[name] for name in Address._fields})
    except (OSError, ValueError, LookupError, TypeError):
        return None


def keep_address(run: Path, address: Address) -> None:
    """Write the address into a run's folder, for its owner's eyes only, whole or not at all."""

    def write(file: Path) -> None:
        handle = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with os.fdopen(handle, "w") as out:
            json.dump({"page": address.page} | address._asdict(), out)

    write_atomically(run / FILE, write)
