"""A campaign: many runs of one deployment, each with random process faults drawn from its seed.

`python -m runtime.campaign.campaign RUN` launches one run in the folder RUN.
"""

import signal
import subprocess
import sys
import time
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from agents.paths import Path as GoalPath
from runtime.campaign.forecast import forecast
from runtime.campaign.impact import Impact, measure_impact
from runtime.chaos.injector import check_means
from runtime.config.chaos import MANNERS, WATCHER, ChaosEvent, fault
from runtime.config.deployment import Deployment, load
from runtime.config.tree import ConfigError
from runtime.errors import RunError
from runtime.launching.launcher import Launcher, prepare
from runtime.processes.lifetime import FAILED
from runtime.results.evaluation import evaluate
from runtime.results.logs import log_lines
from runtime.results.run_log import RunLogError, read_run_log
from runtime.results.summary import close
from runtime.spawning.identity import ProcessId, processes_in
from runtime.spawning.registry import forget
from runtime.spawning.tasks import last_line, spawn
from runtime.tls.verification import verify_all
from runtime.watching.table import off

_MAX_FAULTS = 3  # at most in a run, each in another process
_FAULTS_FROM, _FAULTS_TO = 1 / 6, 5 / 8  # shares of a run's duration
_MIN_LASTING, _MAX_LASTING = 0.5, 3.0  # [s, plant time] of a hang, or from a kill to the restart
_MAX_DRAWS = 100  # draws of one seed, until one leaves the goal within reach
_POLL_PERIOD = 0.05  # [s]
_SHUTDOWN_TIMEOUT = 20.0  # [s] from the end of a run until all its processes must have ended


@dataclass(frozen=True)
class CampaignRun:
    """One run of a campaign.

    Attributes:
        outcome: "reached", "missed", or "failed" if the run could not be evaluated.
        reason: Why it failed; empty otherwise.
        error: Distance of the hand from its goal at the end [m]; None if it never moved.
        angle: Between the orientations of the two [rad]; 0 if any will do.
    """

    seed: int
    chaos: tuple[ChaosEvent, ...]
    outcome: str
    reason: str
    error: float | None
    impact: Impact
    folder: Path
    angle: float = 0.0


def draw(deployment: Deployment, seed: int) -> Deployment:
    """Add random process faults, which leave the goal within reach, to a deployment's chaos.

    `ConfigError` if it has no duration or no goal, or no draw does that.
    """
    duration, path = _end(deployment)
    rng = np.random.default_rng([seed, 0xCA])
    targets = deployment.chaos_targets
    for _ in range(_MAX_DRAWS):
        events: list[ChaosEvent] = []
        count = int(rng.integers(1, _MAX_FAULTS + 1))
        for role in rng.choice(targets, min(count, len(targets)), False):
            at = float(rng.uniform(_FAULTS_FROM, _FAULTS_TO)) * duration
            longest = max(_MIN_LASTING, min(_MAX_LASTING, duration / 8))
            lasting = float(rng.uniform(_MIN_LASTING, longest))
            manner = str(rng.choice(MANNERS))
            events += fault(str(role), manner, round(at, 2), round(lasting, 2))
        chaos = (*deployment.chaos, *sorted(events, key=lambda event: event.at))
        drawn = replace(deployment, seed=seed, chaos=chaos)
        if forecast(drawn, path, duration).in_reach(deployment.tolerance):
            return drawn
    raise ConfigError(f"seed {seed}: none of {_MAX_DRAWS} draws leaves the goal within reach")


def run_once(deployment: Deployment, seed: int) -> CampaignRun:
    """Launch one run, evaluate its logs, and make sure that all its processes have ended."""
    drawn, folder = prepare(draw(deployment, seed))
    assert drawn.duration is not None
    limit = time.monotonic() + drawn.duration / drawn.speed + drawn.patience + _SHUTDOWN_TIMEOUT
    launcher = spawn("runtime.campaign.campaign", [str(folder)], folder / "launcher.out")
    watcher = None
    watched = any(event.role == WATCHER for event in drawn.chaos)
    try:
        while launcher.poll() is None:
            if watched and watcher is None and any(log_lines(folder, "plant", "tick")):
                words = ["status", "--watch", "--file", str(folder / "deployment.yaml")]
                watcher = spawn("runtime.cli", words, folder / "watcher.out")
            time.sleep(_POLL_PERIOD)
        while _remaining(drawn, folder) and time.monotonic() < limit:
            time.sleep(_POLL_PERIOD)
    except BaseException:
        with suppress(subprocess.TimeoutExpired):
            launcher.send_signal(signal.SIGINT)
            launcher.wait(_SHUTDOWN_TIMEOUT)
        raise
    finally:
        for child in filter(None, (launcher, watcher)):
            child.kill()
            child.wait()
        remaining = _remaining(drawn, folder)
        for process in remaining:
            process.send(signal.SIGKILL)
    forget(drawn.robot, folder)
    reason = f"{len(remaining)} processes did not end and were killed" if remaining else ""
    if not reason and launcher.returncode == FAILED:
        reason = last_line(folder / "launcher.out")
    return _evaluated(drawn, folder, reason)


def _evaluated(deployment: Deployment, folder: Path, reason: str) -> CampaignRun:
    chaos, seed = deployment.chaos, deployment.seed
    try:
        log = read_run_log(folder)
    except RunLogError as problem:
        reason = reason or str(problem)
        return CampaignRun(seed, chaos, "failed", reason, None, Impact((), {}), folder)
    evaluation = evaluate(log, deployment)
    assert evaluation.tracking is not None
    assert deployment.duration is not None
    tracking, impact = evaluation.tracking, measure_impact(deployment, folder, log)
    if not reason and evaluation.t < deployment.duration - 1e-9:
        reason = f"the plant ended at {evaluation.t:.2f} s"
    outcome = "reached" if tracking.nearest is None else "missed"
    outcome, end = "failed" if reason else outcome, (tracking.final, impact, folder)
    return CampaignRun(seed, chaos, outcome, reason, *end, tracking.final_angle)


def _remaining(deployment: Deployment, folder: Path) -> list[ProcessId]:
    """Return the processes of a run that outlived its launcher."""
    roles = (*deployment.roles, "successor")
    return [process for role in roles for process in processes_in(folder, role)]


def check_campaign(deployment: Deployment, runs: int) -> None:
    """Raise `ConfigError` if a campaign of this deployment cannot be run."""
    if runs < 1:
        raise ConfigError(f"--runs {runs}: must be at least 1, such as 10")
    duration, path = _end(deployment)
    check_means(deployment, None)
    verify_all(deployment)
    undisturbed = forecast(deployment, path, duration)
    if not undisturbed.in_reach(deployment.tolerance):
        what = f"the hand would end {off(*undisturbed.error)} off even without random faults"
        raise ConfigError(f"the goal is not within reach: {what}; see `msma launch`")


def _end(deployment: Deployment) -> tuple[float, GoalPath]:
    """Return when the runs end [s] and the path by which they are evaluated."""
    if deployment.duration is None or deployment.goal is None:
        raise ConfigError("a campaign needs both `goal` and `duration` to evaluate its runs")
    if deployment.first_mode != "automatic":
        what = "its plant starts at rest, and nobody chooses automatic mode"
        raise ConfigError(f"a campaign of {deployment.robot}: {what}; set start.mode: automatic")
    return deployment.duration, deployment.goal.build()


def _launch(run: Path) -> int:
    """Launch a run that is prepared, in a process of its own, so that chaos can kill it."""
    deployment = load(run / "deployment.yaml")
    try:
        outcome = Launcher(deployment, run, shows=False).go()
    except RunError as error:
        print(error)
        return FAILED
    return close(deployment, run, outcome, plot=False)[0].code


if __name__ == "__main__":
    sys.exit(_launch(Path(sys.argv[1])))
