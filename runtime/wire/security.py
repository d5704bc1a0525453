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
    - operators may query anything below `ctl`, publish the goal, and answer as the launcher;
    - the page may publish the goal, release the robot and choose its mode, and ask the launcher for
      a partition: it alone is connected to the launcher, and only that of a rehearsal agrees;
    - everybody may halt it.

    A rule covers a message if its keys include all of the message's, so a wildcard that reaches
    beyond a role's own keys is refused as a whole. Zenoh sees keys below the robot's name.
    """
    everybody = names(roles)
    allowed: list[tuple[Sequence[str], str, Sequence[str], Sequence[str]]] = [
        (everybody, "egress", _ALL, ["**"]),
        (everybody, "ingress", _READ, ["**"]),
        (everybody, "ingress", ["query"], [topics.EVERY_DIAG]),
        ([OPERATOR], "ingress", ["query"], [topics.EVERY_CONTROL]),
        ([OPERATOR], "ingress", ["put"], [topics.GOAL]),
        ([OPERATOR], "ingress", ["declare_queryable", "reply"], [topics.PARTITION]),
        (everybody, "ingress", ["query"], [topics.HALT]),
    ]
    if topics.PAGE in roles:
        allowed += [
            ([topics.PAGE], "ingress", ["put"], [topics.GOAL]),
            ([topics.PAGE], "ingress", ["query"], [topics.RELEASE, topics.MODE, topics.PARTITION]),
        ]
    for role in roles:
        answers = [f"ctl/{role}/*", topics.diag(role)]
        allowed += [
            ([role], "ingress", ["put"], contract.keys_of(role)),
            ([role], "ingress", ["liveliness_token"], [f"alive/{role}/*"]),
            ([role], "ingress", ["declare_queryable", "reply"], answers),
        ]
    rules, policies = [], []
    for number, (subjects, flow, messages, keys) in enumerate(allowed):
        rule = {"id": str(number), "permission": "allow", "flows": [flow], "messages": messages}
        rules.append({**rule, "key_exprs": [f"{robot}/{key}" for key in keys]})
        policies.append({"rules": [str(number)], "subjects": subjects})
    return {
        "enabled": True,
        "default_permission": "deny",
        "rules": rules,
        "subjects": [{"id": name, "cert_common_names": [name]} for name in everybody],
        "policies": policies,
    }
