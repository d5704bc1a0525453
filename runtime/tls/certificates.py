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

_BOTH_ENDS = [ExtendedKeyUsageOID.SERVER_AUTH, ExtendedKeyUsageOID.CLIENT_AUTH]
_SLACK = timedelta(days=1)  # tolerance for clocks that are late


class KeyPair(NamedTuple):
    """A certificate and its private key, both as PEM text."""

    certificate: str
    private_key: str


class Authority:
    """Signs certificates; its own private key exists only in this object.

    Args:
        robot: The robot's name, which is in its certificate.
        days: How long the authority and its certificates are valid [days].
    """

    def __init__(self, robot: str, days: float) -> None:
        self._key = ec.generate_private_key(ec.SECP256R1())
        self._name = _name(f"authority of {robot}")
        now = datetime.now(UTC)
        self._begin, self._end = now - _SLACK, now + timedelta(days=days)
        signs, usage = x509.BasicConstraints(True, 0), _usage(key_cert_sign=True, crl_sign=True)
        self.certificate = self._sign(self._name, self._key, self._begin, self._end, signs, usage)

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
        begin, end = begin or self._begin, end or self._end
        extensions = (
            x509.BasicConstraints(False, None),
            _usage(digital_signature=True),
            x509.ExtendedKeyUsage(_BOTH_ENDS),
            x509.SubjectAlternativeName([_address(one) for one in addresses]),
            x509.AuthorityKeyIdentifier.from_issuer_public_key(self._key.public_key()),
        )
        kind, plain = serialization.PrivateFormat.PKCS8, serialization.NoEncryption()
        private = key.private_bytes(serialization.Encoding.PEM, kind, plain)
        return KeyPair(self._sign(_name(name), key, begin, end, *extensions), private.decode())

    def _sign(
        self,
        name: x509.Name,
        key: ec.EllipticCurvePrivateKey,
        begin: datetime,
        end: datetime,
        *extensions: x509.ExtensionType,
    ) -> str:
        public, number = key.public_key(), x509.random_serial_number()
        builder = x509.CertificateBuilder(self._name, name, public, number, begin, end)
        for extension in (x509.SubjectKeyIdentifier.from_public_key(public), *extensions):
            critical = isinstance(extension, x509.BasicConstraints | x509.KeyUsage)
            builder = builder.add_extension(extension, critical)
        certificate = builder.sign(self._key, hashes.SHA256())
        return certificate.public_bytes(serialization.Encoding.PEM).decode()


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


def write_keys(
    folder: Path, authority: Authority, names: Iterable[str], addresses: Sequence[str]
) -> None:
    """Write a new key pair for each name, and the authority's certificate, or raise `RunError`."""
    files = {Credentials(folder, "", ()).authority.name: authority.certificate}
    for name in names:
        pair, where = authority.issue(name, addresses), Credentials(folder, name, ())
        files[where.certificate.name] = pair.certificate
        files[where.private_key.name] = pair.private_key
    try:
        write_files(folder, files)
    except OSError as error:
        raise RunError(f"the certificates cannot be written: {error}") from None
