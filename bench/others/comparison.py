"""Our loop beside what one might else pick: how fast it answers, what it costs and survives."""

import math
import sys
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from bench.bench import Bench, BenchError, Check, Result
from bench.echo.runner import Measured
from bench.loop import OURS, PLAIN, run_plain
from bench.msma_runs import ARPH, deployed, run_ours
from bench.others.environments import environment
from bench.others.kills import PERIOD, KillImpact, strike
from bench.others.msma_kills import strike_ours
from bench.others.processes import ProcessGroup
from bench.others.systems import SYSTEMS, System
from bench.others.tables import answers_table, blows_table, costs_table, notes, ready_table
from studies.study import Progress

RATES = {17: 2.5, 100: 1.5, 500: 1.5, 1000: 1.5}
"""Rate [Hz] to how long it is measured in each round [s]; 17 stands for the paper's 60 ms."""
ROUNDS = 3
ENOUGH = 0.5
"""Share of the ticks answered in time below which a system is taken not to follow a rate."""
_TRIES = 2  # of a run that comes to nothing

Runs = dict[int, dict[str, list[Measured]]]
"""Rate to side to its runs."""


@dataclass
class Found:
    """What was measured.

    Attributes:
        versions: Of each system that could be had.
        runs: The loop.
        blows: Side to what each blow did, round by round.
        failures: What came to nothing, in words.
        off: Off the goal at worst in our runs, by rate [m].
    """

    versions: dict[str, str] = field(default_factory=dict)
    runs: Runs = field(default_factory=lambda: defaultdict(lambda: defaultdict(list)))
    blows: dict[str, list[list[KillImpact]]] = field(default_factory=lambda: defaultdict(list))
    failures: list[str] = field(default_factory=list)
    off: dict[int, float] = field(default_factory=lambda: defaultdict(float))


def plan(sides: Sequence[str], rates: Sequence[int], rounds: int) -> Iterator[tuple[int, str]]:
    """Give rate and side of one run after the other, every other round from the other end.

    Rates go upwards in each round, so that who cannot follow one need not be asked the next.
    """
    for number in range(rounds):
        for rate in sorted(rates):
            for side in sides if number % 2 == 0 else reversed(sides):
                yield rate, side


class OthersBench(Bench):
    """Seven agents and a plant over each system in turn, and what happens if one is killed."""

    name = "others"
    title = "Beside others: pyzmq, Cyclone DDS, dora-rs and SPADE"

    def __init__(
        self,
        rates: Mapping[int, float] = RATES,
        rounds: int = ROUNDS,
        systems: Sequence[System] = SYSTEMS,
    ) -> None:
        """Measure at those rates [Hz], each for so long [s] in each round."""
        self._rates, self._rounds, self._systems = rates, rounds, systems

    def measure(self, size: float, progress: Progress) -> Result:
        """Make the environments, then measure all sides in turn, then kill."""
        rounds = max(round(self._rounds * min(4 * size, 1)), 1)
        found = Found()
        pythons = self._environments(found, progress)
        sides = [OURS, PLAIN, *pythons]
        struck = [each for each in self._systems if each.name in pythons and each.blows()]
        progress.begin(rounds * (len(self._rates) * len(sides) + 2 * (1 + len(struck))))
        self._loops(found, sides, pythons, rounds, size, progress)
        self._blows(found, struck, pythons, rounds, progress)
        return Result(
            checks=tuple(_checks(found)),
            bars=(),
            tables=(
                answers_table(found.runs),
                costs_table(found.runs),
                ready_table(found.runs),
                blows_table(found.blows),
            ),
            notes=notes(found.versions, found.failures),
            data=_data(found),
        )

    def draw(self, result: Result, folder: Path) -> tuple[Path, ...]:
        """Draw the answers' times and the gaps."""
        from bench.others.drawing import draw_answers, draw_gaps

        return (
            draw_answers(result.data["loop"], folder / "others.png"),
            draw_gaps(result.data["blows"], folder / "others-killed.png"),
        )

    def _environments(self, found: Found, progress: Progress) -> dict[str, Path]:
        pythons = {}
        progress.begin(len(self._systems))
        for system in self._systems:
            progress.step(f"environment of {system.name}")
            name = system.side.rpartition(".")[2]
            try:
                python, versions = environment(name, system.requirements, _say)
            except BenchError as error:
                found.failures.append(f"{system.name} could not be had: {error}.")
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
        too_fast: dict[str, int] = {}  # of the others only: all are compared to ours and to plain
        failed: Counter[tuple[str, int]] = Counter()
        for rate, side in plan(sides, list(self._rates), rounds):
            progress.step(f"{rate} Hz, {side}")
            if rate >= too_fast.get(side, rate + 1):
                continue
            seconds = max(self._rates[rate] * size, 1.0)
            real = 1 / PERIOD if rate == 17 else float(rate)
            try:
                if side == OURS:
                    run = run_ours(_deployment(rate), seconds)
                    measured = run.measured
                    found.off[rate] = max(found.off[rate], run.error)
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
        deals: dict[str, Callable[[], list[KillImpact]]] = {OURS: strike_ours}
        for system in systems:
            deals[system.name] = partial(strike, system, pythons[system.name])
        for _ in range(rounds):
            for side, deal in deals.items():
                progress.step(f"kills, {side}", 2)
                try:
                    found.blows[side].append(deal())
                except BenchError as error:
                    found.failures.append(f"{side}, when killed: {error}.")


def _say(text: str) -> None:
    print(f"\n{text}", file=sys.stderr, flush=True)


def _run(system: System, python: Path, rate: float, seconds: float) -> Measured:
    with ProcessGroup(python, system.side, rate, seconds) as processes:
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
                continue  # it does not follow: told in the tables
            told = min(
                run.ticks["ticks"] / (run.ticks["ticks"] + run.ticks["missed"]) for run in kept
            )
            silent = {role for run in kept for role, n in run.ticks["heard"].items() if not n}
            text = f"{100 * told:.1f} % of the ticks told, " + (
                f"silent: {', '.join(sorted(silent))}" if silent else "all answer"
            )
            off = f"; hand off by {1e3 * found.off[rate]:.2f} mm" if side == OURS else ""
            passed = told > 0.9 and not silent and (side != OURS or found.off[rate] < 0.006)
            yield Check(f"{rate} Hz, {side}", text + off, passed)
    if not found.runs:
        yield Check("anything", "nothing could be measured", False)


def _finite(value: Any) -> Any:
    """Return what JSON can hold: None for the time of an answer that never came."""
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
        "blows": {
            side: [
                {
                    "what": struck[0].what,
                    "gaps": [each.gap._asdict() for each in struck],
                    "others": [each.others._asdict() for each in struck],
                    "back": [each.back for each in struck],
                }
                for struck in zip(*rounds, strict=True)
            ]
            for side, rounds in found.blows.items()
        },
    }
