"""Whether keys do what they are for: each pair is tried on itself, in memory, as on a link."""

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

_WHENEVER = 0x200000  # of OpenSSL: X509_V_FLAG_NO_CHECK_TIME
_OTHER_USE = 26  # of OpenSSL: X509_V_ERR_INVALID_PURPOSE


class Certificate(NamedTuple):
    """What a certificate says.

    name: of whom
    addresses: where its owner may be reached
    begin, end: when it is good [s since 1970]
    """

    name: str
    addresses: tuple[str, ...]
    begin: float
    end: float


def read(credentials: Credentials) -> Certificate:
    """Return what a certificate says that is signed by the authority and fits its private key.

    Raises `ConfigError` if it is not, or does not. It is not looked at the clock.
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
        for end in (*ends, *ends):  # there are two flights each way
            with suppress(ssl.SSLWantReadError):
                end.do_handshake()
    except ssl.SSLCertVerificationError as error:
        if error.verify_code == _OTHER_USE:
            raise ConfigError(f"{certificate} is not for both ends of a link") from None
        what = f"{certificate} is not signed by {credentials.authority}"
        raise ConfigError(f"{what}: {error.verify_message}") from None
    except ssl.SSLError as error:
        raise ConfigError(f"{certificate} does not work: {error.reason}") from None
    return _said(ends[0].getpeercert() or {})


def _context(protocol: int, credentials: Credentials) -> ssl.SSLContext:
    context = ssl.SSLContext(protocol)
    context.check_hostname = False
    context.verify_mode = ssl.CERT_REQUIRED
    context.verify_flags |= _WHENEVER
    try:
        context.load_verify_locations(credentials.authority)
    except (ssl.SSLError, OSError) as error:
        raise ConfigError(f"{credentials.authority} is no certificate: {_reason(error)}") from None
    try:
        context.load_cert_chain(credentials.certificate, credentials.private_key, password="")
    except (ssl.SSLError, OSError) as error:
        both = f"{credentials.certificate} and {credentials.private_key}"
        raise ConfigError(f"{both} are no pair of keys: {_reason(error)}") from None
    return context


def _reason(error: OSError) -> str:
    return (error.reason if isinstance(error, ssl.SSLError) else error.strerror) or str(error)


def _said(certificate: "ssl._PeerCertRetDictType") -> Certificate:
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
    """Return an address as people write it: OpenSSL writes out all zeros of those of IPv6."""
    try:
        return str(ipaddress.ip_address(address))
    except ValueError:
        return address


def verify(credentials: Credentials, address: str, now: float) -> Certificate:
    """Return the certificate if with it one may be its name at `address`, `now` [s since 1970].

    Raises `ConfigError` that says in plain words why one may not.
    """
    said, file = read(credentials), credentials.certificate
    if said.name != credentials.name:
        raise ConfigError(f"{file} is that of {said.name or 'nobody'}, not of {credentials.name}")
    if now > said.end:
        raise ConfigError(f"{file} has expired, on {day(said.end)}")
    if now < said.begin:
        raise ConfigError(
            f"{file} is not good before {day(said.begin)}, and here it is {day(now)}: is the "
            f"clock right?"
        )
    if _plain(address) not in said.addresses:
        known = ", ".join(said.addresses) or "none"
        raise ConfigError(f"{file} is for another address than {address}: {known}")
    return said


def day(t: float) -> str:
    """Return a time [s since 1970] for people."""
    return time.strftime("%Y-%m-%d %H:%M", time.localtime(t))


def verify_all(deployment: Deployment, host: str | None = None) -> None:
    """Raise `ConfigError` unless all processes of a host, or of all, and an operator can join.

    That they can, if the deployment asks for no certificates.
    """
    if deployment.security is None:
        return
    for name, address in needed(deployment, host):
        credentials = deployment.security.credentials(name, deployment.roles)
        try:
            verify(credentials, address, time.time())
        except ConfigError as error:
            said = f"{deployment.security.keys.file}: security.keys: {error}"
            raise ConfigError(f"{said}; `msma doctor --file` tells more") from None


def needed(deployment: Deployment, host: str | None = None) -> list[tuple[str, str]]:
    """Return the names whose keys a host, or all, needs, and at which addresses they are used."""
    members = [one for one in deployment.processes if host in (None, one.host)]
    there = [(one.role, deployment.hosts[one.host].address) for one in members]
    return [*dict.fromkeys(there), (OPERATOR, LOOPBACK)]


def is_here(address: str) -> bool:
    """Tell whether this machine has an address."""
    with suppress(OSError):
        family, kind, protocol, _, where = socket.getaddrinfo(address, 0)[0]
        with socket.socket(family, kind, protocol) as probe:
            probe.bind(where)
        return True
    return False
