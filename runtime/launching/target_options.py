"""How a tool is told which robot is meant."""

import argparse


def add_target_options(parser: argparse.ArgumentParser) -> None:
    """Let the command say which robot is meant."""
    group = parser.add_argument_group(
        "which robot", "by default the only one that runs on this machine"
    )
    group.add_argument("--robot", metavar="NAME", help="its name on the network")
    group.add_argument(
        "--file",
        metavar="FILE",
        help="its deployment file; needed if that sets its port, hosts or security",
    )
