"""Verification of key pairs: each one makes a TLS handshake with itself, in memory."""

import ipaddress
import socket
import ssl
import time
from contextlib import suppress
from typing import NamedTuple

from runtime.config.deployment import Deployment
from runtime.config.tree import ConfigError
from runtime.wire.mesh import LOOPBACK
from runtime.wire.security import OPERATOR, Credentials

_NO_CHECK_TIME = 0x200000  # X509_V_FLAG_NO_CHECK_TIME of OpenSSL
_INVALID_PURPOSE = 26  # X509_V_ERR_INVALID_PURPOSE of OpenSSL


class Certificate(NamedTuple):
    """The content of a certificate.

    Attributes:
        name: The name of its owner.
        addresses: The addresses at which its owner can be reached.
        begin: Start of validity [s since 1970].
        end: End of validity [s since 1970].
    """

    name: str
    addresses: tuple[str, ...]
    begin: float
    end: float


def read(credentials: Credentials) -> Certificate:
    """Read a certificate, and check its signature and private key, but not its validity period.

    Raises:
        ConfigError: It is not signed by the authority, or does not match its private key.
    """
    server = _context(ssl.PROTOCOL_TLS_SERVER, credentials)
    client = _context(ssl.PROTOCOL_TLS_CLIENT, credentials)
    there, back = ssl.MemoryBIO(), ssl.MemoryBIO()
    ends = (
        client.wrap_bio(back, there),
        server.wrap_bio(there, back, server_side=True),
    )
    certificate = credentials.certificate
    try:
        for end in (*ends, *ends):  # each side sends twice
            with suppress(ssl.SSLWantReadError):
                end.do_handshake()
    except ssl.SSLCertVerificationError as error:
        if error.verify_code == _INVALID_PURPOSE:
            raise ConfigError(f"{certificate} is not valid for both ends of a link") from None
        what = f"{certificate} is not signed by {credentials.authority}"
        raise ConfigError(f"{what}: {error.verify_message}") from None
    except ssl.SSLError as error:
        raise ConfigError(f"{certificate} cannot be used: {error.reason}") from None
    return _content(ends[0].getpeercert() or {})


def _context(protocol: int, credentials: Credentials) -> ssl.SSLContext:
    context = ssl.SSLContext(protocol)
    context.check_hostname = False
    context.verify_mode = ssl.CERT_REQUIRED
    context.verify_flags |= _NO_CHECK_TIME
    try:
        context.load_verify_locations(credentials.authority)
    except (ssl.SSLError, OSError) as error:
        raise ConfigError(
            f"{credentials.authority} is not a certificate: {_reason(error)}"
        ) from None
    try:
        context.load_cert_chain(credentials.certificate, credentials.private_key, password="")
    except (ssl.SSLError, OSError) as error:
        both = f"{credentials.certificate} and {credentials.private_key}"
        raise ConfigError(f"{both} are not a key pair: {_reason(error)}") from None
    return context


def _reason(error: OSError) -> str:
    return (error.reason if isinstance(error, ssl.SSLError) else error.strerror) or str(error)


def _content(certificate: "ssl._PeerCertRetDictType") -> Certificate:
    names = [
        str(pair[1])
        for part in certificate.get("subject", ())
        for pair in part
        if pair[0] == "commonName"
    ]
    return Certificate(
        name=names[0] if names else "",
        addresses=tuple(_plain(str(one[1])) for one in certificate.get("subjectAltName", ())),
        begin=ssl.cert_time_to_seconds(str(certificate["notBefore"])),
        end=ssl.cert_time_to_seconds(str(certificate["notAfter"])),
    )


def _plain(address: str) -> str:
    """Return an address in its short form: OpenSSL writes out all zeros of IPv6 addresses."""
    try:
        return str(ipaddress.ip_address(address))
    except ValueError:
        return address


def verify(credentials: Credentials, address: str, now: float) -> Certificate:
    """Return the certificate, if it can be used at an address and time `now` [s since 1970].

    Raises:
        ConfigError: The certificate cannot be used; the message says why.
    """
    found, file = read(credentials), credentials.certificate
    if found.name != credentials.name:
        raise ConfigError(f"{file} belongs to {found.name or 'nobody'}, not to {credentials.name}")
    if now > found.end:
        raise ConfigError(f"{file} expired on {day(found.end)}")
    if now < found.begin:
        raise ConfigError(
            f"{file} is not valid before {day(found.begin)}, and it is {day(now)} here: "
            f"is the clock right?"
        )
    if _plain(address) not in found.addresses:
        known = ", ".join(found.addresses) or "none"
        raise ConfigError(f"{file} is for another address than {address}: {known}")
    return found


def day(t: float) -> str:
    """Return a time [s since 1970] as local date and time."""
    return time.strftime("%Y-%m-%d %H:%M", time.localtime(t))


def verify_all(deployment: Deployment, host: str | None = None) -> None:
    """Check the certificates of operators and of all processes, or of those on one host.

    Raises:
        ConfigError: A certificate is missing or cannot be used.
    """
    if deployment.security is None:
        return
    for name, address in needed(deployment, host):
        credentials = deployment.security.credentials(name, deployment.roles)
        try:
            verify(credentials, address, time.time())
        except ConfigError as error:
            what = f"{deployment.security.keys.file}: security.keys: {error}"
            raise ConfigError(f"{what}; see `msma doctor --file`") from None


def needed(deployment: Deployment, host: str | None = None) -> list[tuple[str, str]]:
    """Return name and address of each key pair that a host, or all of them, needs."""
    members = [one for one in deployment.processes if host in (None, one.host)]
    there = [(one.role, deployment.hosts[one.host].address) for one in members]
    return [*dict.fromkeys(there), (OPERATOR, LOOPBACK)]


def is_here(address: str) -> bool:
    """Return whether this machine has an address."""
    with suppress(OSError):
        family, kind, protocol, _, where = socket.getaddrinfo(address, 0)[0]
        with socket.socket(family, kind, protocol) as probe:
            probe.bind(where)
        return True
    return False
