"""Verification of key pairs: each one makes a TLS handshake with itself, in memory."""

import ipaddress
import ssl
import time
from contextlib import suppress
from typing import Any, cast

from runtime.config.deployment import Deployment
from runtime.config.tree import ConfigError
from runtime.wire.mesh import LOOPBACK
from runtime.wire.security import OPERATOR, Credentials

_NO_CHECK_TIME = 0x200000  # X509_V_FLAG_NO_CHECK_TIME of OpenSSL
_INVALID_PURPOSE = 26  # X509_V_ERR_INVALID_PURPOSE of OpenSSL


def verify(credentials: Credentials, address: str) -> float:
    """Return when a certificate ends [s since 1970], if it can be used at an address now.

    `ConfigError` if it cannot be used; the message says why.
    """
    file, content, now = credentials.certificate, _handshake(credentials), time.time()
    subject = dict(pair for part in content["subject"] for pair in part)
    name = subject.get("commonName", "")
    if name != credentials.name:
        raise ConfigError(f"{file} belongs to {name or 'nobody'}, not to {credentials.name}")
    end = ssl.cert_time_to_seconds(content["notAfter"])
    if now > end:
        raise ConfigError(f"{file} expired on {day(end)}")
    begin = ssl.cert_time_to_seconds(content["notBefore"])
    if now < begin:
        when = f"{day(begin)}, and it is {day(now)} here"
        raise ConfigError(f"{file} is not valid before {when}: is the clock right?")
    addresses = [_plain(text) for _, text in content.get("subjectAltName", ())]
    if _plain(address) not in addresses:
        known = ", ".join(addresses) or "none"
        raise ConfigError(f"{file} is for another address than {address}: {known}")
    return end


def _handshake(credentials: Credentials) -> dict[str, Any]:
    """Return what is in a certificate, if its authority and key fit, whatever its dates are."""
    client = _context(ssl.PROTOCOL_TLS_CLIENT, credentials)
    server = _context(ssl.PROTOCOL_TLS_SERVER, credentials)
    there, back = ssl.MemoryBIO(), ssl.MemoryBIO()
    ends = client.wrap_bio(back, there), server.wrap_bio(there, back, server_side=True)
    file = credentials.certificate
    try:
        for end in (*ends, *ends):  # each side sends twice
            with suppress(ssl.SSLWantReadError):
                end.do_handshake()
    except ssl.SSLCertVerificationError as error:
        if error.verify_code == _INVALID_PURPOSE:
            raise ConfigError(f"{file} is not valid for both ends of a link") from None
        what = f"{file} is not signed by {credentials.authority}"
        raise ConfigError(f"{what}: {error.verify_message}") from None
    except ssl.SSLError as error:
        raise ConfigError(f"{file} cannot be used: {error.reason}") from None
    return cast(dict[str, Any], ends[0].getpeercert())


def _context(protocol: int, credentials: Credentials) -> ssl.SSLContext:
    context = ssl.SSLContext(protocol)
    context.check_hostname = False
    context.verify_mode = ssl.CERT_REQUIRED
    context.verify_flags |= _NO_CHECK_TIME
    try:
        what = f"{credentials.authority} is not a certificate"
        context.load_verify_locations(credentials.authority)
        what = f"{credentials.certificate} and {credentials.private_key} are not a key pair"
        context.load_cert_chain(credentials.certificate, credentials.private_key, password="")
    except OSError as error:
        reason = error.reason if isinstance(error, ssl.SSLError) else error.strerror
        raise ConfigError(f"{what}: {reason or error}") from None
    return context


def _plain(address: str) -> str:
    """Return an address in its short form: OpenSSL writes out all zeros of IPv6 addresses."""
    try:
        return str(ipaddress.ip_address(address))
    except ValueError:
        return address


def day(t: float) -> str:
    """Return a time [s since 1970] as local date and time."""
    return time.strftime("%Y-%m-%d %H:%M", time.localtime(t))


def verify_all(deployment: Deployment, host: str | None = None) -> None:
    """Check the certificates of operators and of all processes, or of those on one host.

    `ConfigError` if one is missing or cannot be used.
    """
    if deployment.security is None:
        return
    for name, address in needed(deployment, host):
        credentials = deployment.security.credentials(name, deployment.roles)
        try:
            verify(credentials, address)
        except ConfigError as error:
            what = f"{deployment.security.keys.file}: security.keys: {error}"
            raise ConfigError(f"{what}; see `msma doctor --file`") from None


def needed(deployment: Deployment, host: str | None = None) -> list[tuple[str, str]]:
    """Return name and address of each key pair that a host, or all of them, needs."""
    members = [one for one in deployment.processes if host in (None, one.host)]
    there = [(one.role, deployment.hosts[one.host].address) for one in members]
    return [*dict.fromkeys(there), (OPERATOR, LOOPBACK)]
