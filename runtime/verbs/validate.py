"""Check a deployment file without starting anything."""

import argparse
import json
from typing import Any

from runtime.config.deployment import Deployment
from runtime.config.options import add_deployment_options, load_from
from runtime.config.schema import schema


class _PrintSchema(argparse.Action):
    """Prints the schema and exits, like `--help`, so that no file is needed."""

    def __call__(self, parser: argparse.ArgumentParser, *_: Any, **__: Any) -> None:
        print(json.dumps(schema(Deployment), indent=2))
        parser.exit()


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_deployment_options(parser)
    parser.add_argument(
        "--schema",
        action=_PrintSchema,
        nargs=0,
        help="print a JSON schema of deployment files for editors, and exit",
    )


def run(args: argparse.Namespace) -> int:
    deployment = load_from(args)
    count = len(deployment.roles)
    print(f"{args.file}: valid: robot {deployment.robot}, {count} processes")
    return 0
