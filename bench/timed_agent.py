"""An agent process that logs how long each step of its start takes.

Run as `python -m bench.timed_agent FILE ROLE RUN`. All times are wall-clock times, to be compared
with those of the process that started it on the same machine.
"""

import time

began = time.time()  # before anything else is imported

import sys  # noqa: E402
from pathlib import Path  # noqa: E402

from agents.agent import Agent, Array, Percepts  # noqa: E402
from runtime.config.deployment import ProcessSpec, load  # noqa: E402
from runtime.processes.agent_process import AgentNode  # noqa: E402
from runtime.processes.process import Process  # noqa: E402

imported = time.time()

PARTS = "parts"
"""The logged event: the wall-clock times at which each step was done."""


class TimedAgent(Agent):
    """Decides as another agent does, and logs the time of its first decision."""

    def __init__(self, agent: Agent, process: Process, times: dict[str, float]) -> None:
        self._agent, self._process, self._times = agent, process, times
        self.sees, self.rest = agent.sees, agent.rest

    def decide(self, percepts: Percepts) -> Array | None:
        """Return the decision of the other agent."""
        if self._times:
            self._times["percept"] = time.time()
            decision = self._agent.decide(percepts)
            self._process.log.write(percepts.t, PARTS, **self._times, decided=time.time())
            self._times.clear()
            return decision
        return self._agent.decide(percepts)


def main() -> int:
    """Run as `msma agent FILE ROLE --run RUN` does."""
    file, role, run = sys.argv[1:]
    times = {"began": began, "imported": imported}
    deployment = load(file, only_role=role)
    member = ProcessSpec(role, deployment.host_of(role))
    agent = deployment.build_agent(role)
    times["read"] = time.time()
    with Process(deployment, member, Path(file), Path(run)) as process:
        times["joined"] = time.time()
        return process.live(AgentNode(process, TimedAgent(agent, process, times)))


if __name__ == "__main__":
    raise SystemExit(main())
