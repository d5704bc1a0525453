"""End the halt of a running robot; it stays at rest until a mode is chosen."""

import argparse

from runtime.watching.control import Control
from runtime.watching.discovery import add_target_options, target_of, visit


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_target_options(parser)


def run(args: argparse.Namespace) -> int:
    target = target_of(args)
    with visit(target) as bus:
        state, after = Control(bus).release()
    print(f"{target.robot} is {state.text}, confirmed by its plant after {1e3 * after:.0f} ms")
    if state.mode == "rest":
        print("`msma mode automatic` lets its agents move it")
    return 0
