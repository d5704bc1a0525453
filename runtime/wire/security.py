"""Rights on the bus by the name in a certificate: mutual TLS and an access list.

Each process enforces the list on incoming messages, so it does not depend on others to refuse
them. All rights are those of a name; copies of a role share its certificate.
"""

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple

from runtime.wire import topics
from runtime.wire.topics import STANDARD, Contract

OPERATOR = "operator"
"""The name in the certificate of operators: the launcher and all tools."""

_READ = ("declare_subscriber", "liveliness_query", "declare_liveliness_subscriber")
_ALL = (*_READ, "put", "query", "reply", "declare_queryable", "liveliness_token")


class Credentials(NamedTuple):
    """The certificate of a process, and what the rights of others follow from.

    Attributes:
        folder: Folder of the certificates and private keys.
        name: The name in its own certificate: its role, or `OPERATOR`.
        roles: The robot's roles; other names have no rights.
        contract: The robot's topics.
    """

    folder: Path
    name: str
    roles: tuple[str, ...]
    contract: Contract = STANDARD

    @property
    def authority(self) -> Path:
        """The certificate of the authority that all others are signed by."""
        return self.folder / "ca.pem"

    @property
    def certificate(self) -> Path:
        """Its own certificate."""
        return self.folder / f"{topics.file_name(self.name)}.pem"

    @property
    def private_key(self) -> Path:
        """The private key of its certificate."""
        return self.folder / f"{topics.file_name(self.name)}.key"

    @property
    def files(self) -> tuple[Path, ...]:
        """All that it needs to be there."""
        return self.authority, self.certificate, self.private_key


def names(roles: Sequence[str]) -> tuple[str, ...]:
    """Return all names that have rights on the bus of a robot with these roles."""
    return (*roles, OPERATOR)


def encryption(credentials: Credentials) -> dict[str, Any]:
    """Return Zenoh's settings of its links: TLS alone, and both ends show a certificate."""
    certificate, key = str(credentials.certificate), str(credentials.private_key)
    return {
        "protocols": ["tls"],
        "tls": {
            "root_ca_certificate": str(credentials.authority),
            "enable_mtls": True,
            "listen_certificate": certificate,
            "listen_private_key": key,
            "connect_certificate": certificate,
            "connect_private_key": key,
            "verify_name_on_connect": True,
        },
    }


def access_list(robot: str, roles: Sequence[str], contract: Contract = STANDARD) -> dict[str, Any]:
    """Return Zenoh's access control of a robot with these roles and topics.

    Only this is allowed. All names may receive what they subscribe to. Of incoming messages:

    - all names may subscribe, see liveliness tokens, and query diagnostics;
    - a role may publish its own topics by the wire contract, declare its own liveliness token,
      and answer queries to itself;
    - operators may query anything below `ctl`, and publish the goal.

    A rule covers a message if its keys include all of the message's, so a wildcard that reaches
    beyond a role's own keys is refused as a whole. Zenoh sees keys below the robot's name.
    """
    rules = _Rules(f"{robot}/")
    everybody = list(names(roles))
    rules.allow(everybody, "egress", _ALL, "**")
    rules.allow(everybody, "ingress", _READ, "**")
    rules.allow(everybody, "ingress", ("query",), topics.EVERY_DIAG)
    rules.allow([OPERATOR], "ingress", ("query",), topics.EVERY_CONTROL)
    rules.allow([OPERATOR], "ingress", ("put",), topics.GOAL)
    for role in roles:
        answers = (topics.controls(role), topics.diag(role))
        rules.allow([role], "ingress", ("put",), *contract.keys_of(role))
        rules.allow([role], "ingress", ("liveliness_token",), topics.alive_in(role))
        rules.allow([role], "ingress", ("declare_queryable", "reply"), *answers)
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules.rules,
        "subjects": [{"id": name, "cert_common_names": [name]} for name in everybody],
        "policies": rules.policies,
    }


class _Rules:
    """Zenoh's rules, each with the policy that says to whom it applies."""

    def __init__(self, prefix: str) -> None:
        self._prefix = prefix
        self.rules: list[dict[str, Any]] = []
        self.policies: list[dict[str, Any]] = []

    def allow(
        self, subjects: Sequence[str], flow: str, messages: Sequence[str], *expressions: str
    ) -> None:
        """Allow some kinds of messages on some key expressions, in one direction."""
        name = str(len(self.rules))
        self.rules.append(
            {
                "id": name,
                "permission": "allow",
                "flows": [flow],
                "messages": list(messages),
                "key_exprs": [self._prefix + expression for expression in expressions],
            }
        )
        self.policies.append({"rules": [name], "subjects": list(subjects)})
