"""Make the certificates and private keys of a deployment that asks for them."""

import argparse
from pathlib import Path

from plant.errors import MsmaError
from runtime.config.deployment import load
from runtime.config.tree import ConfigError
from runtime.wire.mesh import LOOPBACK
from runtime.wire.security import Credentials, names
from runtime.wire.topics import PLANT

_DAYS = 730


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the folder, the file, and for how long."""
    parser.add_argument("folder", metavar="DIR", type=Path, help="the folder to write them to")
    parser.add_argument("file", metavar="FILE", help="the deployment file: its roles and hosts")
    parser.add_argument(
        "--days", type=float, default=_DAYS, help=f"for how long they are good; by default {_DAYS}"
    )
    parser.add_argument(
        "--overwrite",
        action="store_true",
        help="make all anew, with a new authority: the former ones are good for nothing then",
    )


def run(args: argparse.Namespace) -> int:
    """Make them; 2 if there are some already."""
    deployment = load(args.file, only_role=PLANT)
    if not 0 < args.days <= 36500:
        raise ConfigError(f"--days {args.days:g}: must be positive, and 36500 at most")
    authority = Credentials(args.folder, "", ()).authority
    if authority.exists() and not args.overwrite:
        raise ConfigError(f"there are keys in {args.folder} already; --overwrite makes all anew")
    try:
        from runtime.tls.certificates import Authority, write_keys
    except ImportError:
        raise MsmaError("msma keys needs cryptography: pip install 'msma[keys]'") from None
    hosts = (host.address for host in deployment.hosts.values())
    addresses = tuple(dict.fromkeys((LOOPBACK, *hosts)))
    wanted = names(deployment.roles)
    write_keys(args.folder, Authority(deployment.robot, args.days), wanted, addresses)
    where, count = ", ".join(addresses), len(wanted)
    print(f"{args.folder}: {count} pairs of keys, for {where}, good for {args.days:g} days")
    security = deployment.security
    if security is None or security.keys.path != args.folder.absolute():
        print(f"{args.file} does not use them yet; it must say: security: {{keys: FOLDER}}")
    return 0
