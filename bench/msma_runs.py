"""The processes of a deployment of ours as one side of a comparison."""

import tempfile
from dataclasses import dataclass
from pathlib import Path

from bench.echo.runner import Measurement, run
from bench.machine import free_port
from runtime.config.deployment import Deployment, load
from runtime.config.overrides import Override
from runtime.results.evaluation import SETTLING, errors
from runtime.results.run_log import read_run_log
from runtime.wire import topics

ROOT = Path(__file__).parents[1]
ARPH = ROOT / "deploy" / "arph.yaml"
"""The paper's mobile arm: a plant, a goal, six joints and a platform."""


@dataclass(frozen=True)
class MsmaRun:
    """What one run gave: as of any side, and how far off its goal the hand was.

    error: the worst after `SETTLING`, or in the last half if the run was shorter [m]
    """

    measured: Measurement
    error: float


def deployed(file: Path, *overrides: str) -> Deployment:
    """Return a deployment with values replaced, each such as `period=1 ms`, on free ports."""
    made = []
    for text in (f"port={free_port()}", *overrides):
        path, _, value = text.partition("=")
        made.append(Override(f"--set {text}", path, value))
    return load(file, made)


def run_msma(deployment: Deployment, seconds: float, *, every_state: bool = False) -> MsmaRun:
    """Start all processes of a deployment and measure for `seconds` [s].

    every_state: the agents decide on every state, of use or not
    """
    agents = {spec.role for spec in deployment.agents}
    with tempfile.TemporaryDirectory(prefix="msma-bench-") as place:
        folder = Path(place)
        file = folder / "deployment.yaml"
        file.write_text(deployment.dump(), encoding="utf-8")
        said = folder / "said"
        commands = {topics.PLANT: ["bench.measured_plant", str(file), place, f"{seconds:g}"]}
        for role in deployment.roles:
            if every_state and role in agents:
                commands[role] = ["bench.every_state_agent", str(file), role, place]
            elif role != topics.PLANT:
                commands[role] = ["runtime.cli", "agent", str(file), role, "--run", place]
        measured = run(commands, seconds, errors=said)
        record = read_run_log(folder)
    assert deployment.goal is not None
    off = errors(record, deployment.goal.build())
    late = record.t >= min(SETTLING, record.t[-1] / 2)
    return MsmaRun(measured, float(off[late].max()))
