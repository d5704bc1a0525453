"""What can be wrong with the keys of a deployment, before anything is started."""

import stat
import time
from collections.abc import Iterator

from runtime.config.deployment import Deployment
from runtime.config.tree import ConfigError
from runtime.doctor.machine import Finding, Grade
from runtime.tls.verification import day, is_here, needed, verify
from runtime.wire.security import Credentials

_SOON = 30 * 86400.0  # [s]
_WHAT = "keys"


def keys(deployment: Deployment) -> Iterator[Finding]:
    """Look at the keys that processes on this machine need, if the deployment asks for any."""
    security = deployment.security
    if security is None:
        return
    sound = True
    ends: list[float] = []
    for name, address in needed(deployment):
        if not is_here(address):
            continue
        try:
            credentials = security.credentials(name, deployment.roles)
        except ConfigError as error:
            yield Finding(Grade.BAD, _WHAT, str(error))
            return
        remedy = security.remedy(" --overwrite")
        for finding in _of(credentials, address, ends, remedy):
            sound = False
            yield finding
    if sound and ends:
        soon = min(ends) < time.time() + _SOON
        detail = f"{len(ends)} in {security.keys}, good until {day(min(ends))}"
        yield Finding(Grade.WARN if soon else Grade.OK, _WHAT, detail)


def _of(
    credentials: Credentials, address: str, ends: list[float], remedy: str
) -> Iterator[Finding]:
    """Yield what is wrong with one pair of keys; add when it ends [s since 1970], if it is good."""
    try:
        ends.append(verify(credentials, address, time.time()).end)
    except ConfigError as error:
        yield Finding(Grade.BAD, _WHAT, f"{error}; make all anew: {remedy}")
    mode = stat.S_IMODE(credentials.private_key.stat().st_mode)
    if mode & 0o077:
        file = credentials.private_key
        detail = f"{file} may be read by others, who then may be {credentials.name}"
        yield Finding(Grade.BAD, _WHAT, f"{detail}; `chmod 600 {file}`")
