"""Which node a role has, and its process: it imports only what that needs, to act the sooner."""

import sys
from importlib import import_module
from pathlib import Path

from plant.errors import MsmaError
from runtime.config.deployment import Deployment, ProcessSpec
from runtime.config.reading import kind_of
from runtime.config.specs import GoalSpec, NodeSpec
from runtime.processes.node import Node
from runtime.processes.process import Process
from runtime.wire import topics

_AGENTS = "an agent"
_NEEDED = {
    _AGENTS: ("runtime.processes.agent_process", "agents.joint", "agents.platform"),
    topics.PLANT: ("runtime.plant_node.plant_node", "plant.kinematic"),
    topics.GOAL_SOURCE: ("runtime.processes.goal_process",),
    topics.PAGE: (),  # it brings its own
}


def preload(role: str | None = None) -> None:
    """Import what the process of a role needs, or of any role, for copies of this process."""
    import_module("psutil")
    kind_of(Deployment)  # how its file is read
    for modules in _NEEDED.values() if role is None else [_NEEDED.get(role, _NEEDED[_AGENTS])]:
        for module in modules:
            import_module(module)


def live(deployment: Deployment, member: ProcessSpec, file: Path, run: Path) -> int:
    """Be that process until its end, and return the exit code; `MsmaError` if it cannot start."""
    if member.copy and member.role == topics.PLANT:
        raise MsmaError("the plant is the robot: there can be no copy of it")
    with Process(deployment, member, file, run) as process:
        node = _node(process)
        name = f"{member.role} of {deployment.robot}"
        print(f"{name}: its log is {process.log.path}", file=sys.stderr, flush=True)
        code = process.live(node)
        print(f"{name}: {process.ending.reason}", file=sys.stderr, flush=True)
    return code


def _node(process: Process) -> Node:
    deployment, role = process.deployment, process.role
    if role == topics.PLANT:
        from runtime.plant_node.plant_node import PlantNode

        return PlantNode(process)
    spec = deployment.specs[role]
    if isinstance(spec, GoalSpec):
        from runtime.processes.goal_process import GoalNode

        return GoalNode(process, spec.build())
    if isinstance(spec, NodeSpec):
        process.follow_plant()
        return spec.build()
    from runtime.processes.agent_process import AgentNode

    return AgentNode(process, deployment.build_agent(role))
