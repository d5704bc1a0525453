"""Inject a fault into a running simulated robot, or clear it."""

import argparse

from plant.faults import FaultError
from runtime.errors import RunError
from runtime.watching.discovery import add_target_options, target_of, visit
from runtime.wire import topics


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the fault and the options that name a robot."""
    parser.add_argument(
        "fault",
        metavar="FAULT",
        help="such as joint/1:locked or encoder/2:lost; joint/1:ok clears all faults of joint 1",
    )
    add_target_options(parser)


def run(args: argparse.Namespace) -> int:
    """Request the fault from the plant; print its answer."""
    with visit(target_of(args)) as bus:
        answers = bus.ask(topics.FAULT, args.fault.encode())
    if not answers:
        raise RunError("no plant answers")
    said = answers[0].data.decode(errors="replace")
    if not answers[0].agreed:
        raise FaultError(said)
    print(f"{args.fault}: {said}")
    return 0
