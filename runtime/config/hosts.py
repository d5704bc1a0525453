"""The hosts of a deployment, and where processes run."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

from runtime.config.kinds import Items, Scope, Text
from runtime.config.reading import Derived
from runtime.config.tree import YamlNode
from runtime.errors import valid_are
from runtime.wire.mesh import LOOPBACK


class _Host(Text, frozen=True):
    """The name of one of the deployment's hosts."""

    def read(self, node: YamlNode, scope: Scope) -> str:
        name, names = super().read(node, scope), scope["hosts"]
        if name not in names:
            raise node.error(f"there is no host {name!r}{valid_are(name, names)}")
        return name


_NAME = ("arm", "a host's name", "[A-Za-z0-9][A-Za-z0-9._-]*")
NewHost = Annotated[str, Text(*_NAME)]
SOME_HOSTS = Items("arm", (_Host(*_NAME),), many=True, bare=True)
HostAddress = Annotated[
    str, Text("192.168.0.11", "an address", "[A-Za-z0-9][A-Za-z0-9._-]*|[0-9A-Fa-f:.]+")
]
Router = Annotated[
    str, Text("192.168.0.2:7447", "a router", r"([A-Za-z0-9._-]+|\[[0-9A-Fa-f:.]+\]):[0-9]{1,5}")
]
_EVERYWHERE = ("0.0.0.0", "::")


@dataclass(frozen=True, kw_only=True)
class HostSpec:
    """A machine on which processes run; in a file its address alone is enough.

    Attributes:
        address: Where other hosts reach it: an IP address, or a name with the same address on
            every host.
        ssh: Destination for `ssh`, such as pi@arm.local; by default the address.
        command: The `msma` command on that host.
    """

    address: HostAddress
    ssh: Annotated[str, Derived(lambda scope: scope["address"])]
    command: str = "msma"

    short: ClassVar[str] = "address"

    def check(self, node: YamlNode, scope: Scope) -> None:
        """Refuse an address that is not that of one host."""
        if self.address in _EVERYWHERE:
            what = f"{self.address} is not the address of one host"
            raise node.find("address").error(f"{what}; give the one that other hosts connect to")
        if self.ssh.startswith("-"):
            raise node.find("ssh").error(f"{self.ssh!r} is not a destination, such as pi@arm.local")


def here_alone(_: Scope) -> Mapping[str, HostSpec]:
    """Return the default hosts: this machine alone."""
    return {"local": HostSpec(address=LOOPBACK, ssh=LOOPBACK)}


def _first(scope: Scope) -> str:
    hosts: Mapping[str, HostSpec] = scope["hosts"]
    return next(iter(hosts))


Home = Annotated[str, _Host(*_NAME), Derived(_first)]
"""The host of a process; by default the first of the deployment."""
Homes = Annotated[tuple[str, ...], SOME_HOSTS, Derived(lambda scope: (_first(scope),))]
"""The hosts of a process and of its copies."""
