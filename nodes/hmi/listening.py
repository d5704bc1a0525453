"""Where the page is served, and by which certificate."""

import ssl
from pathlib import Path

from plant.errors import MsmaError

LOOPBACK = ("127.0.0.1", "localhost")


class DoorError(MsmaError, ValueError):
    """The page cannot be served so: it says which parameter is wrong and what would do."""


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


def tls_context(certificate: Path | None, key: Path | None) -> ssl.SSLContext | None:
    """Return what encrypts the page; None without a certificate."""
    if certificate is None or key is None:
        return None
    context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
    try:
        context.load_cert_chain(certificate, key, password="")  # or it would ask for one
    except (OSError, ssl.SSLError) as error:
        raise DoorError(f"certificate: {certificate} with {key} cannot be used: {error}") from None
    return context
