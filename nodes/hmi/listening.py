"""Where the page is served, and by which certificate."""

from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from plant.errors import MsmaError

if TYPE_CHECKING:  # not before there is a certificate
    import ssl

LOOPBACK = ("127.0.0.1", "localhost")


class DoorError(MsmaError, ValueError):
    """The page cannot be served so: it says which parameter is wrong and what would do."""


class Listening(NamedTuple):
    """Where the page is served.

    Attributes:
        port: The port; None for one of its own.
        listen: The address of this computer.
        names: Further names or addresses by which browsers call this computer.
        tls: What encrypts the page.
    """

    port: int | None
    listen: str
    names: tuple[str, ...]
    tls: "ssl.SSLContext | None"


def check_listen(
    listen: str, names: tuple[str, ...], certificate: Path | None, key: Path | None
) -> None:
    """Raise `DoorError` for a page that others could reach without encryption, or by any name."""
    if (certificate is None) != (key is None):
        missing = "key" if key is None else "certificate"
        raise DoorError(f"{missing}: is needed too: certificate and key belong together")
    if listen in LOOPBACK:
        return
    if certificate is None:
        raise DoorError(
            f"listen: at {listen} other computers reach the page, and the token could be read on "
            f"its way. Give a certificate and its key too, or remove this for {LOOPBACK[0]}"
        )
    if listen in ("0.0.0.0", "::", "") and not names:
        raise DoorError(
            f"names: needed with listen: {listen}: the names or addresses by which browsers call "
            f"this computer, such as [robot.local, 192.168.1.5]"
        )


def tls_context(certificate: Path | None, key: Path | None) -> "ssl.SSLContext | None":
    """Return what encrypts the page; None without a certificate."""
    if certificate is None or key is None:
        return None
    import ssl

    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    try:
        context.load_cert_chain(certificate, key, password="")  # or it would ask for one
    except (OSError, ssl.SSLError) as error:
        raise DoorError(f"certificate: {certificate} with {key} cannot be used: {error}") from None
    return context
