"""An agent's process that decides on every state, of use or not: what that would cost.

Run as `python -m bench.eager FILE ROLE RUN`; it lives as `msma agent FILE ROLE --run RUN` does.
"""

import sys
from pathlib import Path

from runtime.config.deployment import ProcessSpec, load
from runtime.processes.agent_process import AgentLoop
from runtime.processes.process import Process


def main() -> int:
    """Live as that agent, without a rest."""
    file, role, run = sys.argv[1:]
    deployment = load(file, only_role=role)
    member = ProcessSpec(role, deployment.host_of(role))
    agent = deployment.build_agent(role)
    agent.rest = 0.0
    with Process(deployment, member, Path(file), Path(run)) as process:
        return process.live(AgentLoop(process, agent))


if __name__ == "__main__":
    raise SystemExit(main())
