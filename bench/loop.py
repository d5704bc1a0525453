"""The loop from state to command through real processes, beside an echo over plain Zenoh.

At the rates where processor time is the limit, also beside an echo that decides: the limit on this
machine for this number of Python processes with these laws and messages.
"""

import time
from collections.abc import Callable, Container, Mapping
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from statistics import median

from bench.bench import Bench, Check, Result, Table
from bench.echo.deciding_zenoh import tick_work
from bench.echo.runner import Measurement
from bench.echo.runner import run as run_side
from bench.echo.workload import AGENTS, ROLES, EchoSpec, to_args
from bench.interleaving import Ratio, interleaved, ratio
from bench.loop_tables import (
    BUSY,
    DECIDING,
    EVERY_STATE,
    NOTES,
    OURS,
    PAGE_OPEN,
    PLAIN,
    Runs,
    costs_table,
    due,
    in_time,
    times_table,
)
from bench.machine import busy_cores, free_port
from bench.msma_runs import ARPH, PAGE, deployed, run_msma
from studies.study import Progress, Row

RATES = {17: 5.0, 100: 4.0, 500: 20.0, 1000: 6.0, 2000: 3.0}
"""Rates [Hz], and the duration of each in a round [s]; 99.99 % takes ten thousands of ticks."""
ROUNDS = 3
DETAILED = (500, 1000)
"""Rates [Hz] with further variants: those of the bars on time and processors."""
_REPETITIONS = 500
_NOISE = 1.1  # of one 99th percentile over another, that says nothing in so few runs
WITH_PAGE = (1000,)
"""Rates [Hz] that are also measured with a page open, if `msma[web]` is installed."""
MOST_OFF = 0.006
"""Largest error of a run that counts as done [m]: at 60 ms, twice that of the paper."""


class LoopBench(Bench):
    """Latency, share of ticks answered, processor time and memory at five rates."""

    name = "loop"
    title = "The loop of a plant and seven agents, beside an echo over plain Zenoh"

    def __init__(
        self,
        rates: Mapping[int, float] = RATES,
        rounds: int = ROUNDS,
        detailed: Container[int] = DETAILED,
        with_page: Container[int] = WITH_PAGE,
    ) -> None:
        """Measure at rates [Hz], each for a duration [s] in each round; some with all variants."""
        self._rates, self._rounds, self._detailed = rates, rounds, detailed
        self._with_page = with_page if find_spec("websockets") else ()

    def measure(self, size: float, progress: Progress) -> Result:
        """Measure all systems at each rate, interleaved."""
        rounds = max(round(self._rounds * min(4 * size, 1)), 1)
        off: dict[int, list[float]] = {rate: [] for rate in self._rates}
        sides = {
            rate: _sides(
                rate,
                max(full * size, 1.0),
                off[rate],
                progress,
                detailed=rate in self._detailed,
                with_page=rate in self._with_page,
            )
            for rate, full in self._rates.items()
        }
        progress.begin(rounds * sum(len(at_rate) for at_rate in sides.values()))
        checks: list[Check] = []
        found: dict[int, Runs] = {}
        for rate in self._rates:
            found[rate] = interleaved(sides[rate], rounds)
            checks += _checks(rate, found[rate], max(off[rate]))
        return Result(
            checks=tuple(checks),
            bars=tuple(bars(found)),
            tables=(times_table(found), costs_table(found), *work_tables(found)),
            notes=NOTES,
            data={
                str(rate): {
                    side: [
                        {"ticks": run.ticks, "usage": {r: asdict(u) for r, u in run.usage.items()}}
                        for run in runs
                    ]
                    for side, runs in sides.items()
                }
                for rate, sides in found.items()
            },
        )

    def draw(self, result: Result, folder: Path) -> tuple[Path, ...]:
        """Draw the latencies."""
        from bench.drawing import latencies

        curves = {
            f"{rate} Hz": {
                side: [
                    median(column)
                    for column in zip(*(r["ticks"]["curve"] for r in runs), strict=True)
                ]
                for side, runs in sides.items()
            }
            for rate, sides in result.data.items()
        }
        return (latencies(curves, folder / "loop.png"),)


def _sides(
    rate: int,
    seconds: float,
    errors: list[float],
    progress: Progress,
    *,
    detailed: bool,
    with_page: bool,
) -> dict[str, Callable[[], Measurement]]:
    """Return functions that measure each system at a rate.

    Args:
        rate: [Hz].
        seconds: Duration [s].
        errors: Takes the worst error of the hand in MSMA's runs [m].
        progress: Receives which system is measured.
        detailed: Measure the variants too.
        with_page: Measure it with its page open too.
    """

    def ours(*, every_state: bool = False, page: bool = False) -> Measurement:
        period = "60 ms" if rate == 17 else f"{1e3 / rate:g} ms"
        name = f"robot=bench-loop-{rate}"
        more = PAGE if page else ()
        deployment = deployed(ARPH, name, f"period={period}", "plant.hold=240 ms", *more)
        run = run_msma(deployment, seconds, every_state=every_state)
        errors.append(run.error)
        return run.measured

    def beside_busy_loops() -> Measurement:
        with busy_cores():
            return ours()

    def shown(side: str, measure: Callable[[], Measurement]) -> Callable[[], Measurement]:
        def go() -> Measurement:
            progress.step(f"{rate} Hz, {side}")
            return measure()

        return go

    hertz = 1 / 0.06 if rate == 17 else rate
    sides: dict[str, Callable[[], Measurement]] = {
        OURS: ours,
        PLAIN: lambda: run_plain(hertz, seconds),
    }
    if detailed:
        sides[DECIDING] = lambda: run_plain(hertz, seconds, decides=True)
        sides[EVERY_STATE] = lambda: ours(every_state=True)
        sides[BUSY] = beside_busy_loops
    if with_page:
        sides[PAGE_OPEN] = lambda: ours(page=True)
    return {side: shown(side, measure) for side, measure in sides.items()}


def run_plain(rate: float, seconds: float, *, decides: bool = False) -> Measurement:
    """Run the echo over plain Zenoh; with `decides`, its processes also decide."""
    port = free_port()
    program = "bench.echo.deciding_zenoh" if decides else "bench.echo.plain_zenoh"
    return run_side(
        {role: [program, *to_args(EchoSpec(role, rate, seconds, port))] for role in ROLES},
        seconds,
    )


def _checks(rate: int, sides: Runs, off: float) -> list[Check]:
    checks = [
        Check(
            f"{rate} Hz, {OURS}: largest error of the hand", f"{1e3 * off:.2f} mm", off < MOST_OFF
        )
    ]
    for side, runs in sides.items():
        sent = min(run.ticks["ticks"] / (run.ticks["ticks"] + run.ticks["missed"]) for run in runs)
        silent = [
            role for run in runs for role, answers in run.ticks["heard"].items() if not answers
        ]
        text = f"{100 * sent:.2f} % sent, all answer" if not silent else f"no answer: {silent}"
        # the shares sent and answered in time are results, not checks: at 2 kHz they show the limit
        checks.append(Check(f"{rate} Hz, {side}: ticks sent", text, not silent))
    return checks


def bars(found: Mapping[int, Runs]) -> list[Row]:
    """Return the bars, beside the limit where processor time decides."""
    rows = []
    if 1000 in found:
        slower = _slower(found[1000], OURS)
        text = f"{slower.text()}; {DECIDING}: {_slower(found[1000], DECIDING).text()}"
        rows += [
            _answered(1000, found[1000], 0.999),
            Row("1 kHz: p99 over that of plain Zenoh", "at most 1.5 x", text, slower.median <= 1.5),
        ]
        if PAGE_OPEN in found[1000]:
            rows.append(_with_page(found[1000]))
    if 500 in found:
        cores = {side: median(run.cores for run in runs) for side, runs in found[500].items()}
        text = _beside({side: f"{each:.2f} cores" for side, each in cores.items()})
        rows += [
            _answered(500, found[500], 0.9999),
            Row("500 Hz: processor time of all processes", "under 1 core", text, cores[OURS] < 1),
        ]
    if 17 in found:
        used = [usage for run in found[17][OURS] for usage in run.usage.values()]
        cpu, pss = max(usage.cpu for usage in used), max(usage.pss for usage in used)
        cost, size = f"{100 * cpu:.1f} %", f"{pss / 1e6:.1f} MB (PSS)"
        rows += [
            Row("60 ms: processor time of each process", "under 5 % of a core", cost, cpu < 0.05),
            Row("60 ms: memory of each process", "under 60 MB", size, pss < 60e6),
        ]
    return rows


def _with_page(sides: Runs) -> Row:
    """Return how much slower all is with a page open, by how much its runs differ without one."""
    times = {side: [run.time("p99") for run in sides[side]] for side in (PAGE_OPEN, OURS)}
    slower = ratio(times[PAGE_OPEN], times[OURS])
    noise = max(times[OURS]) / min(times[OURS])
    bar = max(noise, _NOISE)
    text = f"{slower.text()}; without it the runs differ by {noise:.2f} x"
    return Row("1 kHz, a page open: p99 over that without", "within noise", text,
               slower.median <= bar)  # fmt: skip


def _slower(sides: Runs, side: str) -> Ratio:
    times = {each: [run.time("p99") for run in sides[each]] for each in (side, PLAIN)}
    return ratio(times[side], times[PLAIN])


def _answered(rate: int, sides: Runs, bar: float) -> Row:
    shares = {}
    for side, runs in sides.items():
        total = due(runs)
        late = total - in_time(runs)
        shares[side] = f"{100 * (1 - late / total):.3f} % (all but {late} of {total})"
    what = f"{rate} Hz: answered by all in the period"
    held = in_time(sides[OURS]) >= bar * due(sides[OURS])
    return Row(what, f"{100 * bar:g} %", _beside(shares), held)


def _beside(figures: Mapping[str, str]) -> str:
    """Return MSMA's figure, followed by the others with their names."""
    others = [f"{side}: {figure}" for side, figure in figures.items() if side != OURS]
    return "; ".join((figures[OURS], *others))


def work_tables(found: Mapping[int, Runs]) -> list[Table]:
    """Return the cost of unpacking, deciding and packing per tick, alone and beside the others."""
    rates = [rate for rate, sides in found.items() if DECIDING in sides]
    if not rates:
        return []
    rows = []
    for role in (ROLES[0], *AGENTS):
        more = [
            median(
                with_it.usage[role].cpu - without.usage[role].cpu
                for with_it, without in zip(found[rate][DECIDING], found[rate][PLAIN], strict=True)
            )
            / rate
            for rate in rates
        ]
        alone = _alone(tick_work(role, 1 / max(rates)).whole)
        rows.append((role, f"{1e6 * alone:.0f}", *(f"{1e6 * each:.0f}" for each in more)))
    head = ("process", "alone, repeated", *(f"at {rate} Hz, beside all others" for rate in rates))
    title = "processor time of unpacking, deciding and packing, in us per tick"
    return [Table(title, head, tuple(rows))]


def _alone(work: Callable[[], object]) -> float:
    """Return the processor time of work [s] that is repeated with warm caches."""
    for _ in range(_REPETITIONS):
        work()
    begun = time.thread_time()
    for _ in range(_REPETITIONS):
        work()
    return (time.thread_time() - begun) / _REPETITIONS
