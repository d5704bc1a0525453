"""Choose who moves a running robot: nobody, its agents, or a person at its page."""

import argparse
from typing import get_args

from runtime.watching.control import Control
from runtime.watching.discovery import add_target_options, target_of, visit
from runtime.wire.operator_messages import Mode


def add_arguments(parser: argparse.ArgumentParser) -> None:
    what = "automatic lets its agents move it; shared and manual move nothing without a press"
    parser.add_argument("mode", choices=get_args(Mode), help=what)
    add_target_options(parser)


def run(args: argparse.Namespace) -> int:
    target = target_of(args)
    with visit(target) as bus:
        state, after = Control(bus).mode(args.mode)
    print(f"{target.robot} is {state.text}, confirmed by its plant after {1e3 * after:.0f} ms")
    return 0
