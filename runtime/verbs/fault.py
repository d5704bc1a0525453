"""Inject a fault into a running simulated robot, or clear it."""

import argparse

from runtime.watching.control import Control
from runtime.watching.discovery import add_target_options, target_of, visit


def add_arguments(parser: argparse.ArgumentParser) -> None:
    fault = "such as joint/1:locked or encoder/2:lost; joint/1:ok clears all faults of joint 1"
    add_target_options(parser, fault=fault)


def run(args: argparse.Namespace) -> int:
    with visit(target_of(args)) as bus:
        said = Control(bus).fault(args.fault)
    print(f"{args.fault}: {said}")
    return 0
