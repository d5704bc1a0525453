"""An agent process that decides on every state, to measure what `Agent.rest` saves.

`python -m bench.every_state_agent FILE ROLE RUN` behaves otherwise as `msma agent FILE ROLE --run
RUN`.
"""

import sys
from pathlib import Path

from runtime.config.deployment import ProcessSpec, load
from runtime.processes.agent_process import AgentNode
from runtime.processes.process import Process


def main() -> int:
    """Run the agent that the command line names."""
    file, role, run = sys.argv[1:]
    deployment = load(file, only_role=role)
    member = ProcessSpec(role, deployment.host_of(role))
    agent = deployment.build_agent(role)
    agent.rest = 0.0
    with Process(deployment, member, Path(file), Path(run)) as process:
        return process.live(AgentNode(process, agent))


if __name__ == "__main__":
    raise SystemExit(main())
