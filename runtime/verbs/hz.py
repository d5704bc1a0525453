"""Measure the rate and jitter of the messages on a topic."""

import argparse
import time
from itertools import pairwise
from statistics import pstdev

from runtime.errors import RunError
from runtime.watching.discovery import add_target_options, target_of, visit


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--seconds", metavar="S", type=float, default=3.0, help="duration (default: 3)"
    )
    add_target_options(parser, topic="such as arm/ee_pose or arm/joint/*/cmd")


def run(args: argparse.Namespace) -> int:
    arrivals: dict[str, list[float]] = {}
    with visit(target_of(args)) as bus:
        bus.subscribe(
            args.topic, lambda key, _: arrivals.setdefault(key, []).append(time.monotonic())
        )
        time.sleep(args.seconds)
    if not arrivals:
        raise RunError(f"no messages on {args.topic} in {args.seconds:g} s")
    for key, times in sorted(arrivals.items()):
        print(f"{key}: {evenness(times)}")
    return 0


def evenness(times: list[float]) -> str:
    """Return the rate and intervals of arrivals at `times` [s] as text."""
    intervals = [after - before for before, after in pairwise(times)]
    if not intervals:
        return "1 message"
    rate = len(intervals) / (times[-1] - times[0])
    least, most, jitter = (1e3 * x for x in (min(intervals), max(intervals), pstdev(intervals)))
    return (
        f"{rate:.5g} Hz over {len(times)} messages; intervals {least:.3g} to {most:.3g} ms, "
        f"standard deviation {jitter:.3g} ms"
    )
