"""Measure how often messages come on a key, and how evenly."""

import argparse
import time
from itertools import pairwise
from statistics import pstdev

from runtime.errors import RunError
from runtime.watching.discovery import add_target_options, target_of, visit


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add which robot, which keys and how long."""
    parser.add_argument("key", metavar="KEY", help="such as arm/ee_pose or arm/joint/*/cmd")
    parser.add_argument(
        "--seconds", metavar="S", type=float, default=3.0, help="how long to listen"
    )
    add_target_options(parser)


def run(args: argparse.Namespace) -> int:
    """Listen and say; 1 if nothing came."""
    heard: dict[str, list[float]] = {}
    with visit(target_of(args)) as bus:
        bus.subscribe(args.key, lambda key, _: heard.setdefault(key, []).append(time.monotonic()))
        time.sleep(args.seconds)
    if not heard:
        raise RunError(f"nothing came on {args.key} in {args.seconds:g} s")
    for key, times in sorted(heard.items()):
        print(f"{key}: {evenness(times)}")
    return 0


def evenness(times: list[float]) -> str:
    """Return rate and intervals of arrivals at `times` [s], for people."""
    intervals = [after - before for before, after in pairwise(times)]
    if not intervals:
        return "1 message"
    rate = len(intervals) / (times[-1] - times[0])
    least, most, jitter = (1e3 * x for x in (min(intervals), max(intervals), pstdev(intervals)))
    return (
        f"{rate:.5g} Hz over {len(times)} messages; between two {least:.3g} to {most:.3g} ms, "
        f"standard deviation {jitter:.3g} ms"
    )
