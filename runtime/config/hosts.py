"""The hosts of a deployment, and where processes run."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, ClassVar

from runtime.config.kinds import Among, OneOrMore, Pattern, Scope
from runtime.config.reading import Derived
from runtime.config.tree import YamlNode
from runtime.wire.mesh import LOOPBACK

_NAME = Pattern("[A-Za-z0-9][A-Za-z0-9._-]*", "a host's name", "arm")
NewHost = Annotated[str, _NAME]
Host = Annotated[str, _NAME, Among("hosts", "host")]
"""The name of one of the deployment's hosts."""
HostAddress = Annotated[
    str, Pattern("[A-Za-z0-9][A-Za-z0-9._-]*|[0-9A-Fa-f:.]+", "an address", "192.168.0.11")
]
Router = Annotated[
    str, Pattern(r"([A-Za-z0-9._-]+|\[[0-9A-Fa-f:.]+\]):[0-9]{1,5}", "a router", "192.168.0.2:7447")
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


Home = Annotated[Host, Derived(_first)]
"""The host of a process; by default the first of the deployment."""
Homes = Annotated[tuple[Host, ...], OneOrMore(), Derived(lambda scope: (_first(scope),))]
"""The hosts of a process and of its copies."""
