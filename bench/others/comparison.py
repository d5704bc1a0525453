"""MSMA's loop beside other systems: latency, cost, and the effect of kills."""

import math
import sys
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from bench.bench import Bench, BenchError, Check, Result
from bench.echo.runner import Measurement
from bench.loop import run_plain
from bench.loop_tables import OURS, PLAIN
from bench.msma_runs import ARPH, deployed, run_msma
from bench.others.environments import environment
from bench.others.kills import PERIOD, KillImpact, measure_kills
from bench.others.msma_kills import measure_msma_kills
from bench.others.processes import ProcessGroup
from bench.others.systems import SYSTEMS, System
from bench.others.tables import costs_table, kills_table, latency_table, notes, ready_table
from studies.study import Progress

RATES = {17: 2.5, 100: 1.5, 500: 1.5, 1000: 1.5}
"""Rate [Hz] to how long it is measured in each round [s]; 17 stands for the paper's 60 ms."""
ROUNDS = 3
ENOUGH = 0.5
"""Share of ticks answered in time below which a system does not sustain a rate."""
_TRIES = 2  # of a run that fails

Runs = dict[int, dict[str, list[Measurement]]]
"""By rate [Hz], by system, its runs."""


@dataclass
class Found:
    """All results.

    Attributes:
        versions: Version of each installed system.
        runs: Runs of the loop.
        kills: By system, the effect of each kill in each round.
        failures: What failed, as text.
        error: Largest error of the hand in MSMA's runs, by rate [m].
    """

    versions: dict[str, str] = field(default_factory=dict)
    runs: Runs = field(default_factory=lambda: defaultdict(lambda: defaultdict(list)))
    kills: dict[str, list[list[KillImpact]]] = field(default_factory=lambda: defaultdict(list))
    failures: list[str] = field(default_factory=list)
    error: dict[int, float] = field(default_factory=lambda: defaultdict(float))


def plan(sides: Sequence[str], rates: Sequence[int], rounds: int) -> Iterator[tuple[int, str]]:
    """Yield the rate and the system of each run, with every other round in reverse order.

    Rates increase within a round, so that a system that does not sustain one can be left out after.
    """
    for number in range(rounds):
        for rate in sorted(rates):
            for side in sides if number % 2 == 0 else reversed(sides):
                yield rate, side


class OthersBench(Bench):
    """Seven agents and a plant over each system in turn, and the effect of kills."""

    name = "others"
    title = "Other systems: pyzmq, Cyclone DDS, dora-rs and SPADE"

    def __init__(
        self,
        rates: Mapping[int, float] = RATES,
        rounds: int = ROUNDS,
        systems: Sequence[System] = SYSTEMS,
    ) -> None:
        """Measure at rates [Hz], each for a duration [s] in each round."""
        self._rates, self._rounds, self._systems = rates, rounds, systems

    def measure(self, size: float, progress: Progress) -> Result:
        """Make the environments, then measure all systems in turn, then apply the kills."""
        rounds = max(round(self._rounds * min(4 * size, 1)), 1)
        found = Found()
        pythons = self._environments(found, progress)
        sides = [OURS, PLAIN, *pythons]
        killed = [each for each in self._systems if each.name in pythons and each.kills()]
        progress.begin(rounds * (len(self._rates) * len(sides) + 2 * (1 + len(killed))))
        self._loops(found, sides, pythons, rounds, size, progress)
        self._blows(found, killed, pythons, rounds, progress)
        return Result(
            checks=tuple(_checks(found)),
            bars=(),
            tables=(
                latency_table(found.runs),
                costs_table(found.runs),
                ready_table(found.runs),
                kills_table(found.kills),
            ),
            notes=notes(found.versions, found.failures),
            data=_data(found),
        )

    def draw(self, result: Result, folder: Path) -> tuple[Path, ...]:
        """Draw the latencies and the gaps."""
        from bench.others.drawing import draw_answers, draw_gaps

        return (
            draw_answers(result.data["loop"], folder / "others.png"),
            draw_gaps(result.data["kills"], folder / "others-killed.png"),
        )

    def _environments(self, found: Found, progress: Progress) -> dict[str, Path]:
        pythons = {}
        progress.begin(len(self._systems))
        for system in self._systems:
            progress.step(f"environment of {system.name}")
            name = system.adapter.rpartition(".")[2]
            try:
                python, versions = environment(name, system.requirements, _say)
            except BenchError as error:
                found.failures.append(f"{system.name} could not be installed: {error}.")
                continue
            package = system.requirements[0].partition("=")[0]
            pythons[system.name] = python
            found.versions[system.name] = versions[package]
        return pythons

    def _loops(
        self,
        found: Found,
        sides: Sequence[str],
        pythons: Mapping[str, Path],
        rounds: int,
        size: float,
        progress: Progress,
    ) -> None:
        by_name = {system.name: system for system in self._systems}
        too_fast: dict[str, int] = {}  # never MSMA or plain Zenoh: all are compared with these
        failed: Counter[tuple[str, int]] = Counter()
        for rate, side in plan(sides, list(self._rates), rounds):
            progress.step(f"{rate} Hz, {side}")
            if rate >= too_fast.get(side, rate + 1):
                continue
            seconds = max(self._rates[rate] * size, 1.0)
            real = 1 / PERIOD if rate == 17 else float(rate)
            try:
                if side == OURS:
                    run = run_msma(_deployment(rate), seconds)
                    measured = run.measured
                    found.error[rate] = max(found.error[rate], run.error)
                elif side == PLAIN:
                    measured = run_plain(real, seconds)
                else:
                    measured = _run(by_name[side], pythons[side], real, seconds)
            except BenchError as error:
                found.failures.append(f"{side} at {rate} Hz: {error}.")
                failed[side, rate] += 1
                if failed[side, rate] == _TRIES and side in by_name:
                    too_fast[side] = rate
                continue
            found.runs[rate][side].append(measured)
            if measured.in_time < ENOUGH and side in by_name:
                too_fast[side] = rate

    def _blows(
        self,
        found: Found,
        systems: Sequence[System],
        pythons: Mapping[str, Path],
        rounds: int,
        progress: Progress,
    ) -> None:
        measures: dict[str, Callable[[], list[KillImpact]]] = {OURS: measure_msma_kills}
        for system in systems:
            measures[system.name] = partial(measure_kills, system, pythons[system.name])
        for _ in range(rounds):
            for side, measure in measures.items():
                progress.step(f"kills, {side}", 2)
                try:
                    found.kills[side].append(measure())
                except BenchError as error:
                    found.failures.append(f"{side}, when killed: {error}.")


def _say(text: str) -> None:
    print(f"\n{text}", file=sys.stderr, flush=True)


def _run(system: System, python: Path, rate: float, seconds: float) -> Measurement:
    with ProcessGroup(python, system.adapter, rate, seconds) as processes:
        system.start(processes)
        return processes.measured()


def _deployment(rate: int) -> Any:
    period = "60 ms" if rate == 17 else f"{1e3 / rate:g} ms"
    return deployed(ARPH, "robot=bench-others", f"period={period}", "plant.hold=240 ms")


def _checks(found: Found) -> Iterator[Check]:
    for rate, sides in found.runs.items():
        for side, runs in sides.items():
            kept = [run for run in runs if run.in_time >= ENOUGH]
            if not kept:
                continue  # it does not sustain this rate: see the tables
            sent = min(
                run.ticks["ticks"] / (run.ticks["ticks"] + run.ticks["missed"]) for run in kept
            )
            silent = {role for run in kept for role, n in run.ticks["heard"].items() if not n}
            text = f"{100 * sent:.1f} % of the ticks sent, " + (
                f"no answers from {', '.join(sorted(silent))}" if silent else "all answer"
            )
            off = f"; error of the hand {1e3 * found.error[rate]:.2f} mm" if side == OURS else ""
            passed = sent > 0.9 and not silent and (side != OURS or found.error[rate] < 0.006)
            yield Check(f"{rate} Hz, {side}", text + off, passed)
    if not found.runs:
        yield Check("anything", "nothing could be measured", False)


def _finite(value: Any) -> Any:
    """Return a value for JSON, with None for an infinite time."""
    if isinstance(value, Mapping):
        return {name: _finite(each) for name, each in value.items()}
    if isinstance(value, list):
        return [_finite(each) for each in value]
    return None if value == math.inf else value


def _data(found: Found) -> dict[str, Any]:
    return {
        "versions": found.versions,
        "failures": found.failures,
        "loop": {
            str(rate): {
                side: [
                    {
                        "ticks": _finite(run.ticks),
                        "ready": run.ready,
                        "usage": {name: asdict(usage) for name, usage in run.usage.items()},
                    }
                    for run in runs
                ]
                for side, runs in sides.items()
            }
            for rate, sides in found.runs.items()
        },
        "kills": {
            side: [
                {
                    "what": killed[0].what,
                    "gaps": [each.gap._asdict() for each in killed],
                    "others": [each.others._asdict() for each in killed],
                    "back": [each.back for each in killed],
                }
                for killed in zip(*rounds, strict=True)
            ]
            for side, rounds in found.kills.items()
        },
    }
