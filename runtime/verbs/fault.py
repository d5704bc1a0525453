"""Break something in a running simulated robot, or mend it."""

import argparse

from plant.faults import FaultError
from runtime.errors import RunError
from runtime.watching.discovery import add_target_options, target_of, visit
from runtime.wire import topics


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add which robot and what breaks."""
    parser.add_argument(
        "fault", metavar="FAULT", help="such as joint/1:locked, encoder/2:lost or joint/1:ok"
    )
    add_target_options(parser)


def run(args: argparse.Namespace) -> int:
    """Ask the plant for it; 2 if there is no such fault, 1 if there is no plant."""
    with visit(target_of(args)) as bus:
        answers = bus.ask(topics.FAULT, args.fault.encode())
    if not answers:
        raise RunError("no plant answers")
    said = answers[0].data.decode(errors="replace")
    if not answers[0].agreed:
        raise FaultError(said)
    print(f"{args.fault}: {said}")
    return 0
