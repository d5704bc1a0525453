"""An agent in this process beside a plant in one of its own, so that a test can look at it."""

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress

from agents.agent import Agent
from runtime.config.deployment import ProcessSpec, load
from runtime.config.overrides import Override
from runtime.processes.agent_process import AgentNode
from runtime.processes.process import Process
from runtime.wire.bus import BusError
from tests.runtime.conftest import DEADLINE, ProcessGroup


def live_as_joint_1(
    processes: ProcessGroup, agent: Agent, period: str, meanwhile: Callable[[], object]
) -> None:
    """Start a plant, and let the agent live beside it until `meanwhile` returns."""
    patience = f"{DEADLINE:g}s"  # the plant may take long to start
    wanted = {"robot": processes.robot, "port": f"{processes.port}", "period": period}
    wanted["patience"] = patience
    deployment = load(processes.file, [Override("here", *item) for item in wanted.items()])
    member = ProcessSpec("joint/1", deployment.host_of("joint/1"))
    processes.options += ["--set", f"period={period}", "--set", f"patience={patience}"]
    processes.start("plant")

    def live() -> None:
        with Process(deployment, member, processes.file, processes.run) as process:
            node = AgentNode(process, agent)

            def run() -> None:
                with suppress(BusError):  # it may be just about to tell something
                    node.run(process)

            thread = threading.Thread(target=run)
            thread.start()
            meanwhile()
            process.bus.close()
            thread.join(5.0)

    with ThreadPoolExecutor(1) as own:  # since how a process is scheduled is a thread's affair
        own.submit(live).result()
