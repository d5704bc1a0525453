"""Which loop a role has, and its whole life in one call.

A process imports only the loop of its own role: what it need not import is time in which a revived
one acts already.
"""

import sys
from importlib import import_module
from pathlib import Path

from plant.errors import MsmaError
from runtime.config.deployment import Deployment, ProcessSpec
from runtime.processes.process import Loop, Process
from runtime.wire import topics

_AGENTS = "an agent"
_NEEDED = {
    _AGENTS: ("runtime.processes.agent_process", "agents.joint", "agents.platform"),
    topics.PLANT: ("runtime.processes.plant_process",),
    topics.GOAL_SOURCE: ("runtime.processes.goal_process",),
}
"""What the process of a role imports besides this module."""


def preload(role: str | None = None) -> None:
    """Import what the process of a role needs, or of any role, for copies of this process."""
    import_module("psutil")
    for modules in _NEEDED.values() if role is None else [_NEEDED.get(role, _NEEDED[_AGENTS])]:
        for module in modules:
            import_module(module)


def live(deployment: Deployment, member: ProcessSpec, file: Path, run: Path | None = None) -> int:
    """Be that process until its end, and return the exit code.

    `file` is where the deployment was read from, `run` the folder of the log: if it is not
    given, that of the others which run already, or else a new one. Raises `MsmaError` if it
    cannot begin.
    """
    if member.copy and member.role == topics.PLANT:
        raise MsmaError("the plant is the robot: there can be no copy of it")
    with Process(deployment, member, file, run) as process:
        loop = _loop(process)
        place = f"{member.role} of {deployment.robot}"
        print(f"{place}: its log is {process.log.path}", file=sys.stderr, flush=True)
        code = process.live(loop)
        print(f"{place}: {process.ending.reason}", file=sys.stderr, flush=True)
    return code


def _loop(process: Process) -> Loop:
    deployment, role = process.deployment, process.role
    if role == topics.PLANT:
        from runtime.processes.plant_process import PlantLoop

        return PlantLoop(process)
    if role == topics.GOAL_SOURCE and deployment.goal is not None:
        from runtime.processes.goal_process import GoalLoop

        return GoalLoop(process, deployment.goal.build())
    from runtime.processes.agent_process import AgentLoop

    return AgentLoop(process, deployment.build_agent(role))
