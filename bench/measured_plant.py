"""MSMA's plant process with the stopwatch of the benches instead of its own meters."""

import argparse
from pathlib import Path

from bench.ticks import Ticks
from runtime.config.deployment import load
from runtime.plant_node.plant_node import PlantNode
from runtime.processes.meters import AnswerTimes
from runtime.processes.process import Process
from runtime.wire import topics


class StopwatchMeter(AnswerTimes):
    """Passes each sent tick and each answer to the stopwatch."""

    def __init__(self, ticks: Ticks, period: float) -> None:
        super().__init__()
        self._ticks, self._step = ticks, period

    def sent(self, t: float, now: float) -> None:
        """Record that the state of plant time `t` [s] is sent `now` [s, monotonic]."""
        self._ticks.sent(round(t / self._step), now)

    def answered(self, role: str, t: float, now: float) -> None:
        """Record that an answer of `role` to the state of `t` [s] arrives `now` [s, monotonic]."""
        self._ticks.answered(role, round(t / self._step), now)


def main() -> int:
    """Run the plant of a deployment, and measure."""
    parser = argparse.ArgumentParser(description="A plant that measures its agents.")
    parser.add_argument("file", type=Path)
    parser.add_argument("run", type=Path)
    parser.add_argument("seconds", type=float)
    args = parser.parse_args()
    deployment = load(args.file, only_role=topics.PLANT)
    period = deployment.period
    ticks = Ticks([agent.role for agent in deployment.agents], period, args.seconds)
    with Process(deployment, deployment.processes[0], args.file, args.run) as process:
        return process.live(PlantNode(process, StopwatchMeter(ticks, period)))


if __name__ == "__main__":
    raise SystemExit(main())
