"""Say whether a deployment file is valid, and where it is not."""

import argparse
import json
from collections.abc import Sequence
from typing import Any

from runtime.config.deployment import Deployment
from runtime.config.options import add_deployment_options, load_from
from runtime.config.schema import schema


class _PrintSchema(argparse.Action):
    """Prints the schema and ends, as `--help` does, so that no file need be given."""

    def __call__(
        self,
        parser: argparse.ArgumentParser,
        namespace: argparse.Namespace,
        values: str | Sequence[Any] | None,
        option_string: str | None = None,
    ) -> None:
        print(json.dumps(schema(Deployment), indent=2))
        parser.exit()


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the file, its overrides and `--schema`."""
    add_deployment_options(parser)
    parser.add_argument(
        "--schema",
        action=_PrintSchema,
        nargs=0,
        help="print a JSON schema of deployment files, for editors, and end",
    )


def run(args: argparse.Namespace) -> int:
    """Check all that can be checked without starting anything."""
    deployment = load_from(args)
    count = len(deployment.roles)
    print(f"{args.file}: valid: robot {deployment.robot}, {count} processes")
    return 0
