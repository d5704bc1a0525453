"""Creation of certificates: an authority, and a key pair for each name, in a folder."""

import inspect
import ipaddress
from collections.abc import Iterable, Sequence
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import NamedTuple

from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import ExtendedKeyUsageOID, NameOID

from runtime.errors import RunError
from runtime.tls.key_files import write_files
from runtime.wire.security import Credentials

_SLACK = timedelta(days=1)  # tolerance for clocks that are late


class KeyPair(NamedTuple):
    """A certificate and its private key, both as PEM text."""

    certificate: str
    private_key: str


class Authority:
    """Signs certificates; its own private key exists only in this object.

    Args:
        robot: Name of the robot.
        days: How long the authority and its certificates are valid [days].
    """

    def __init__(self, robot: str, days: float) -> None:
        self._key = ec.generate_private_key(ec.SECP256R1())
        self._name = _name(f"authority of {robot}")
        self._end = datetime.now(UTC) + timedelta(days=days)
        usage = _usage(key_cert_sign=True, crl_sign=True)
        own = self._builder(self._name, self._key, datetime.now(UTC) - _SLACK, self._end)
        own = own.add_extension(x509.BasicConstraints(ca=True, path_length=0), critical=True)
        own = own.add_extension(usage, critical=True)
        self.certificate = _pem(own.sign(self._key, hashes.SHA256()))

    def issue(
        self,
        name: str,
        addresses: Iterable[str],
        begin: datetime | None = None,
        end: datetime | None = None,
    ) -> KeyPair:
        """Create a key pair of a name, for a process that can be reached at these addresses.

        By default it is valid from a day ago, since clocks differ, until the authority's end.
        """
        key = ec.generate_private_key(ec.SECP256R1())
        both = [ExtendedKeyUsageOID.SERVER_AUTH, ExtendedKeyUsageOID.CLIENT_AUTH]
        issuer = x509.AuthorityKeyIdentifier.from_issuer_public_key(self._key.public_key())
        begin = begin or datetime.now(UTC) - _SLACK
        builder = self._builder(_name(name), key, begin, end or self._end)
        for extension, critical in (
            (x509.BasicConstraints(ca=False, path_length=None), True),
            (_usage(digital_signature=True), True),
            (x509.ExtendedKeyUsage(both), False),
            (x509.SubjectAlternativeName([_address(one) for one in addresses]), False),
            (issuer, False),
        ):
            builder = builder.add_extension(extension, critical=critical)
        kind, plain = serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
        private = key.private_bytes(serialization.Encoding.PEM, kind, plain)
        return KeyPair(_pem(builder.sign(self._key, hashes.SHA256())), private.decode())

    def _builder(
        self, name: x509.Name, key: ec.EllipticCurvePrivateKey, begin: datetime, end: datetime
    ) -> x509.CertificateBuilder:
        """Return what all certificates have in common."""
        public = key.public_key()
        identifier = x509.SubjectKeyIdentifier.from_public_key(public)
        builder = x509.CertificateBuilder(self._name, name, public, x509.random_serial_number())
        builder = builder.not_valid_before(begin).not_valid_after(end)
        return builder.add_extension(identifier, critical=False)


def _name(text: str) -> x509.Name:
    return x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, text)])


def _usage(**uses: bool) -> x509.KeyUsage:
    every = inspect.signature(x509.KeyUsage).parameters
    return x509.KeyUsage(**(dict.fromkeys(every, False) | uses))


def _address(text: str) -> x509.GeneralName:
    try:
        return x509.IPAddress(ipaddress.ip_address(text))
    except ValueError:
        return x509.DNSName(text)


def _pem(certificate: x509.Certificate) -> str:
    return certificate.public_bytes(serialization.Encoding.PEM).decode()


def write_keys(
    folder: Path, authority: Authority, names: Iterable[str], addresses: Sequence[str]
) -> None:
    """Create a key pair for each name, and write them and the authority's certificate.

    Only the owner can read the private keys, and the folder if it is new.

    Raises:
        RunError: The files cannot be written.
    """
    files = {Credentials(folder, "", ()).authority.name: authority.certificate}
    for name in names:
        pair, where = authority.issue(name, addresses), Credentials(folder, name, ())
        files[where.certificate.name] = pair.certificate
        files[where.private_key.name] = pair.private_key
    try:
        write_files(folder, files)
    except OSError as error:
        raise RunError(f"the certificates cannot be written: {error}") from None
