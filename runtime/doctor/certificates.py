"""Checks of the certificates and private keys that a deployment needs on this machine."""

import stat
import time
from collections.abc import Iterator

from runtime.config.deployment import Deployment
from runtime.config.tree import ConfigError
from runtime.doctor.machine import Finding, Grade
from runtime.spawning.ports import is_taken
from runtime.tls.verification import day, needed, verify

_SOON = 30 * 86400.0  # [s] before expiry: warn
_WHAT = "certificates"


def check_certificates(deployment: Deployment) -> Iterator[Finding]:
    """Check the key pair of each process on this machine, if the deployment has `security`."""
    security = deployment.security
    if security is None:
        return
    expiries, bad = [], []
    for name, address in needed(deployment):
        if is_taken(0, address):  # of another machine
            continue
        try:
            credentials = security.credentials(name, deployment.roles)
        except ConfigError as error:
            bad.append(str(error))
            break
        try:
            expiries.append(verify(credentials, address))
        except ConfigError as error:
            bad.append(f"{error}; replace all: {security.remedy(' --overwrite')}")
        file = credentials.private_key
        if stat.S_IMODE(file.stat().st_mode) & 0o077:
            what = f"{file} can be read by other users, who could act as {name}"
            bad.append(f"{what}; `chmod 600 {file}`")
    for detail in bad:
        yield Finding(Grade.BAD, _WHAT, detail)
    if expiries and not bad:
        soon = min(expiries) < time.time() + _SOON
        detail = f"{len(expiries)} in {security.keys}, valid until {day(min(expiries))}"
        yield Finding(Grade.WARN if soon else Grade.OK, _WHAT, detail)
