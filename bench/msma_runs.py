"""Measured runs of MSMA's processes."""

import tempfile
from dataclasses import dataclass
from pathlib import Path

from bench.bench import BenchError
from bench.echo.runner import Measurement, run
from bench.machine import free_port
from bench.ticks import PATIENCE
from runtime.config.deployment import Deployment, load
from runtime.config.overrides import Override
from runtime.results.evaluation import SETTLING, errors
from runtime.results.logs import read_log
from runtime.results.run_log import read_run_log
from runtime.wire import topics

ROOT = Path(__file__).parents[1]
PAGE = ("nodes.+={role: hmi, class: nodes.hmi.page:Page}", "start.mode=automatic")
"""Overrides that add the page by which a person drives, to a robot that goes on as without it."""
VIEWER = "viewer"
"""The role of what looks at the page."""
ARPH = ROOT / "deploy" / "arph.yaml"
"""The paper's mobile arm: a plant, a goal, six joints and a platform."""


@dataclass(frozen=True)
class MsmaRun:
    """Results of one run of MSMA.

    Attributes:
        measured: Results as for any system.
        error: Largest error of the hand after `SETTLING`, or in the last half of a shorter run [m].
    """

    measured: Measurement
    error: float


def deployed(file: Path, *overrides: str) -> Deployment:
    """Return a deployment on free ports, as patient as the bench, with overrides: `period=1 ms`."""
    made = []
    for text in (f"port={free_port()}", f"patience={PATIENCE:g} s", *overrides):
        path, _, value = text.partition("=")
        made.append(Override(f"--set {text}", path, value))
    return load(file, made)


def run_msma(deployment: Deployment, seconds: float, *, every_state: bool = False) -> MsmaRun:
    """Start all processes of a deployment, and measure; its page, if it has one, is looked at.

    Args:
        deployment: The deployment.
        seconds: Duration of the measurement [s].
        every_state: Let the agents decide on every state, without `Agent.rest`.

    Raises:
        BenchError: The measurement failed; the message has the reasons of processes that ended.
    """
    agents = {spec.role for spec in deployment.agents}
    with tempfile.TemporaryDirectory(prefix="msma-bench-") as name:
        folder = Path(name)
        file = folder / "deployment.yaml"
        file.write_text(deployment.dump(), encoding="utf-8")
        said = folder / "said"
        commands = {topics.PLANT: ["bench.measured_plant", str(file), name, f"{seconds:g}"]}
        for role in deployment.roles:
            if every_state and role in agents:
                commands[role] = ["bench.every_state_agent", str(file), role, name]
            elif role != topics.PLANT:
                commands[role] = ["runtime.cli", "agent", str(file), role, "--run", name]
        if deployment.has_page:
            commands[VIEWER] = ["bench.page_viewer", name]
        try:
            measured = run(commands, seconds, errors=said)
        except BenchError as error:  # the logs are gone after this
            raise BenchError("\n".join([str(error), *_ends(folder, deployment)])) from None
        record = read_run_log(folder)
    assert deployment.goal is not None
    off = errors(record, deployment.goal.build())[:, 0]
    late = record.t >= min(SETTLING, record.t[-1] / 2)
    return MsmaRun(measured, float(off[late].max()))


def _ends(folder: Path, deployment: Deployment) -> list[str]:
    """Return why processes of a run have ended, as their logs say."""
    found = [(role, line) for role in deployment.roles for line in read_log(folder, role, "end")]
    return [f"{role} ended: {line['reason']}" for role, line in found]
