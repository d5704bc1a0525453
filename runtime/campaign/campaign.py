"""A campaign: many runs of one deployment, each with faults of processes drawn from its seed."""

import signal
import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from agents.paths import Path as GoalPath
from runtime.campaign.forecast import forecast
from runtime.campaign.impact import Impact, aftermath
from runtime.chaos.injector import check_means
from runtime.config.chaos import WATCHER, ChaosEvent
from runtime.config.deployment import Deployment
from runtime.config.random_chaos import MANNERS, fault
from runtime.config.tree import ConfigError
from runtime.launching.launcher import prepare
from runtime.results.evaluation import evaluate
from runtime.results.logs import read_log
from runtime.results.run_log import RunLogError, read_run_log
from runtime.spawning.local import lives, send
from runtime.spawning.tasks import spawn
from runtime.tls.verification import verify_all
from runtime.watching.local import logged
from runtime.watching.table import distance

MOST = 3
"""Faults in one run: one to so many, each of another process."""
FROM, TO = 1 / 6, 5 / 8
"""Parts of a run's duration between which faults begin."""
SHORTEST, LONGEST = 0.5, 3.0
"""Of a hang, and of the time until a killed process is started again [s, plant time]."""
_TRIES = 100  # draws until one leaves the goal in reach
_TURN = 0.05  # [s] between two looks
_LEAVING = 20.0  # [s] after the end of a run by which all its processes are gone


@dataclass(frozen=True)
class CampaignRun:
    """One run of a campaign.

    Attributes:
        seed: What decided all that was random in it.
        chaos: What was to happen.
        outcome: reached, missed, or failed if it did not come to a evaluation.
        why: Of a failure.
        error: Distance of the hand from its goal at the end [m], None if it never moved.
        after: What the faults did.
        run: Its folder.
    """

    seed: int
    chaos: tuple[ChaosEvent, ...]
    outcome: str
    why: str
    error: float | None
    after: Impact
    run: Path


def draw(deployment: Deployment, seed: int) -> Deployment:
    """Return a deployment with faults of processes drawn from a seed, beside its own chaos.

    What takes the goal out of reach is drawn again: see `forecast`. Raises `ConfigError` if there
    is no end or no goal to evaluate by, or nothing else to draw.
    """
    duration, path = _end(deployment)
    rng = np.random.default_rng([seed, 0xCA])
    for _ in range(_TRIES):
        events: list[ChaosEvent] = []
        count = int(rng.integers(1, MOST + 1))
        for role in rng.choice(
            deployment.chaos_targets, min(count, len(deployment.chaos_targets)), False
        ):
            at = float(rng.uniform(FROM, TO)) * duration
            lasting = float(rng.uniform(SHORTEST, max(SHORTEST, min(LONGEST, duration / 8))))
            manner = str(rng.choice(MANNERS))
            events += fault(str(role), manner, round(at, 2), round(lasting, 2))
        chaos = (*deployment.chaos, *sorted(events, key=lambda event: event.at))
        drawn = replace(deployment, seed=seed, chaos=chaos)
        if forecast(drawn, path, duration).in_reach(deployment.tolerance):
            return drawn
    raise ConfigError(f"of {_TRIES} draws of seed {seed} none left the goal in reach")


def carry_out(deployment: Deployment, seed: int) -> CampaignRun:
    """Do one run, evaluate it by its logs, and see that nothing is left of it."""
    drawn = draw(deployment, seed)
    run = prepare(drawn)
    began = time.monotonic()
    assert drawn.duration is not None
    with _launched(drawn, run) as launcher:
        _wait(launcher, drawn, run)
        limit = began + drawn.duration / drawn.speed + drawn.patience + _LEAVING
        while (left := _left(drawn, run)) and time.monotonic() < limit:
            time.sleep(_TURN)
        for pid in left:
            send(pid, signal.SIGKILL)
    why = f"{len(left)} processes were left and had to be killed" if left else ""
    if not why and launcher.returncode == 1:
        out = (run / "launcher.out").read_text(encoding="utf-8", errors="replace").strip()
        why = out.split("\n")[-1]
    return _judged(drawn, run, why)


def _judged(deployment: Deployment, run: Path, why: str) -> CampaignRun:
    chaos, seed = deployment.chaos, deployment.seed
    try:
        record = read_run_log(run)
    except RunLogError as problem:
        return CampaignRun(seed, chaos, "failed", why or str(problem), None, Impact((), {}), run)
    evaluation = evaluate(record, deployment)
    assert evaluation.tracking is not None
    assert deployment.duration is not None
    error, after = evaluation.tracking.final, aftermath(deployment, run, record)
    if not why and evaluation.t < deployment.duration - 1e-9:
        why = f"the plant ended at {evaluation.t:.2f} s"
    outcome = "reached" if error <= deployment.tolerance else "missed"
    return CampaignRun(seed, chaos, "failed" if why else outcome, why, error, after, run)


@contextmanager
def _launched(deployment: Deployment, run: Path) -> Iterator["subprocess.Popen[bytes]"]:
    """Launch a run; at an interruption it is interrupted too, and nothing is left of it."""
    launcher = spawn("runtime.campaign.single_run", [str(run)], run / "launcher.out")
    try:
        yield launcher
    except BaseException:
        with suppress(subprocess.TimeoutExpired):
            send(launcher.pid, signal.SIGINT)
            launcher.wait(_LEAVING)
        launcher.kill()
        for pid in _left(deployment, run):
            send(pid, signal.SIGKILL)
        raise
    finally:
        launcher.wait()


def _wait(launcher: "subprocess.Popen[bytes]", deployment: Deployment, run: Path) -> None:
    """Wait for the launcher's end; if chaos is to hit a watcher, there is one."""
    watcher = None
    wanted = any(event.role == WATCHER for event in deployment.chaos)
    try:
        while launcher.poll() is None:
            if wanted and watcher is None and read_log(run, "plant", "tick"):
                words = ["status", "--watch", "--file", str(run / "deployment.yaml")]
                watcher = spawn("runtime.cli", words, run / "watcher.out")
            time.sleep(_TURN)
    finally:
        if watcher is not None:
            watcher.kill()
            watcher.wait()


def _left(deployment: Deployment, run: Path) -> list[int]:
    """Return the processes that are left of a run, whose launcher is gone."""
    left = [pid for role in deployment.roles for pid in logged(run, role)]
    heirs = [line["pid"] for line in read_log(run, "successor", "start")]
    return left + [pid for pid in heirs if lives(pid)]


def check(deployment: Deployment, runs: int) -> None:
    """Refuse a campaign that cannot be."""
    if runs < 1:
        raise ConfigError(f"--runs {runs}: one at least is wanted, such as 10")
    duration, path = _end(deployment)
    check_means(deployment, None)
    verify_all(deployment)
    alone = forecast(deployment, path, duration)
    if not alone.in_reach(deployment.tolerance):
        what = f"the hand would end {distance(alone.error)} off even without faults by lot"
        raise ConfigError(f"the goal is not in reach: {what}; see `msma launch`")


def _end(deployment: Deployment) -> tuple[float, GoalPath]:
    """Return when the runs end [s] and the path that they are judged by."""
    if deployment.duration is None or deployment.goal is None:
        raise ConfigError("a campaign judges by the goal at the end: give goal and duration")
    return deployment.duration, deployment.goal.build()
