"""Checks of the certificates and private keys that a deployment needs on this machine."""

import stat
import time
from collections.abc import Iterator

from runtime.config.deployment import Deployment
from runtime.config.tree import ConfigError
from runtime.doctor.machine import Finding, Grade
from runtime.tls.verification import day, is_here, needed, verify
from runtime.wire.security import Credentials

_SOON = 30 * 86400.0  # [s] before expiry: warn
_WHAT = "certificates"


def check_certificates(deployment: Deployment) -> Iterator[Finding]:
    """Check the key pair of each process on this machine, if the deployment has `security`."""
    security = deployment.security
    if security is None:
        return
    valid = True
    expiries: list[float] = []
    for name, address in needed(deployment):
        if not is_here(address):
            continue
        try:
            credentials = security.credentials(name, deployment.roles)
        except ConfigError as error:
            yield Finding(Grade.BAD, _WHAT, str(error))
            return
        remedy = security.remedy(" --overwrite")
        for finding in _check_pair(credentials, address, expiries, remedy):
            valid = False
            yield finding
    if valid and expiries:
        soon = min(expiries) < time.time() + _SOON
        detail = f"{len(expiries)} in {security.keys}, valid until {day(min(expiries))}"
        yield Finding(Grade.WARN if soon else Grade.OK, _WHAT, detail)


def _check_pair(
    credentials: Credentials, address: str, expiries: list[float], remedy: str
) -> Iterator[Finding]:
    """Check one key pair; append its expiry [s since 1970] if it is valid."""
    try:
        expiries.append(verify(credentials, address, time.time()).end)
    except ConfigError as error:
        yield Finding(Grade.BAD, _WHAT, f"{error}; replace all: {remedy}")
    mode = stat.S_IMODE(credentials.private_key.stat().st_mode)
    if mode & 0o077:
        file = credentials.private_key
        detail = f"{file} can be read by other users, who could act as {credentials.name}"
        yield Finding(Grade.BAD, _WHAT, f"{detail}; `chmod 600 {file}`")
