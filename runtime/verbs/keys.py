"""Create the certificates and private keys of a deployment with `security`."""

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
    parser.add_argument("folder", metavar="DIR", type=Path, help="folder to write the files to")
    parser.add_argument("file", metavar="FILE", help="deployment file with the roles and hosts")
    parser.add_argument(
        "--days", type=float, default=_DAYS, help=f"validity in days (default: {_DAYS})"
    )
    parser.add_argument(
        "--overwrite",
        action="store_true",
        help="replace all files; the old certificates no longer work",
    )


def run(args: argparse.Namespace) -> int:
    """Create the files; refuse to replace old ones without `--overwrite`."""
    deployment = load(args.file, only_role=PLANT)
    if not 0 < args.days <= 36500:
        raise ConfigError(f"--days {args.days:g}: must be positive and at most 36500")
    if Credentials(args.folder, "", ()).authority.exists() and not args.overwrite:
        raise ConfigError(f"{args.folder} has certificates already; replace them: --overwrite")
    try:
        from runtime.tls.certificates import Authority, write_keys
    except ImportError:
        raise MsmaError("msma keys needs cryptography: pip install 'msma[keys]'") from None
    hosts = (host.address for host in deployment.hosts.values())
    addresses = tuple(dict.fromkeys((LOOPBACK, *hosts)))
    owners = names(deployment.roles)
    write_keys(args.folder, Authority(deployment.robot, args.days), owners, addresses)
    where = ", ".join(addresses)
    print(f"{args.folder}: {len(owners)} key pairs, for {where}, valid for {args.days:g} days")
    security = deployment.security
    if security is None or security.keys.path != args.folder.absolute():
        print(f"{args.file} does not use them yet; add to it: security: {{keys: FOLDER}}")
    return 0
