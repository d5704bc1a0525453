"""Our plant as a process of its own, with the stopwatch of the benches in place of its meters."""

import argparse
from pathlib import Path

from bench.ticks import Ticks
from runtime.config.deployment import load
from runtime.processes.meters import AnswerTimes
from runtime.processes.plant_process import PlantNode
from runtime.processes.process import Process
from runtime.wire import topics


class Watched(AnswerTimes):
    """Keeps each state that is published and each answer, exactly."""

    def __init__(self, ticks: Ticks, period: float) -> None:
        super().__init__()
        self._ticks, self._step = ticks, period

    def sent(self, t: float, now: float) -> None:
        """Note that the state of plant time `t` [s] was published `now` [s]."""
        self._ticks.sent(round(t / self._step), now)

    def answered(self, role: str, t: float, now: float) -> None:
        """Note that the answer of a role to the state of `t` [s] arrived `now` [s]."""
        self._ticks.answered(role, round(t / self._step), now)


def main() -> int:
    """Be the plant of a deployment, and measure for a while."""
    parser = argparse.ArgumentParser(description="The plant, measured.")
    parser.add_argument("file", type=Path)
    parser.add_argument("run", type=Path)
    parser.add_argument("seconds", type=float)
    args = parser.parse_args()
    deployment = load(args.file, only_role=topics.PLANT)
    period = deployment.period
    ticks = Ticks([agent.role for agent in deployment.agents], period, args.seconds)
    with Process(deployment, deployment.processes[0], args.file, args.run) as process:
        return process.live(PlantNode(process, Watched(ticks, period)))


if __name__ == "__main__":
    raise SystemExit(main())
