"""Start all processes of a robot, stay with them to the end of the run, and say how it went."""

import argparse
from typing import TYPE_CHECKING

from runtime.config.options import add_deployment_options, load_from
from runtime.launching.launcher import Launcher, prepare
from runtime.launching.saying import say

if TYPE_CHECKING:
    from runtime.launching.screen import Screen


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the file and its overrides."""
    add_deployment_options(parser)


def run(args: argparse.Namespace) -> int:
    """Launch; 0 if the hand ends within tolerance of the goal, 3 if it does not."""
    deployment = load_from(args)

    def make_screen() -> "Screen":
        from runtime.launching.screen import open_screen

        return open_screen(deployment.duration)

    folder = prepare(deployment)
    course = Launcher(deployment, folder, make_screen).go()
    from runtime.launching.closing import close

    summary, picture = close(deployment, folder, course)
    say(f"{summary.text()}\n{picture}".rstrip())
    return summary.code
