"""The loop from state to command through real processes, beside plain Zenoh that only echoes.

Where a bar is a matter of processors' time, beside an echo that also reads and decides: what is to
be had on the machine for as many processes in Python with these laws and messages.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from statistics import median

from bench.bench import Bench, Check, Result, Table
from bench.echo.deciding_zenoh import tick_work
from bench.echo.runner import Measurement
from bench.echo.runner import run as run_side
from bench.echo.workload import AGENTS, ROLES, EchoSpec, to_args
from bench.interleaving import Ratio, interleaved, ratio
from bench.machine import busy_cores, free_port
from bench.msma_runs import ARPH, deployed, run_msma
from studies.study import Progress, Row

RATES = {17: 5.0, 100: 4.0, 500: 20.0, 1000: 6.0, 2000: 3.0}
"""Rate [Hz] to how long it is measured in each round [s]: to tell 99.99 % takes ten thousands."""
ROUNDS = 3
DETAILED = (500, 1000)
"""Rates [Hz] at which there are more sides: those of the bars on time and processors."""
OURS, PLAIN, DECIDING = "msma", "plain Zenoh", "plain Zenoh that reads and decides"
EVERY_STATE = "msma, deciding on every state"
"""Ours again without `Agent.rest`: what that saves."""
BUSY = "msma, other programs on all cores"
"""Ours again beside as many programs as there are cores, none of which rests: nor do the cores."""
_THOUGHTS = 500  # in a row
MOST_OFF = 0.006
"""Off the goal in a run that counts as done [m]: at 60 ms, twice what the paper says."""

Runs = Mapping[str, Sequence[Measurement]]


class LoopBench(Bench):
    """Answer times, share of ticks answered, processors and memory at five rates."""

    name = "loop"
    title = "The loop: plant and seven agents, beside plain Zenoh that only echoes"

    def __init__(self, rates: Mapping[int, float] = RATES, rounds: int = ROUNDS) -> None:
        """Measure at those rates [Hz], each for so long [s] in each round."""
        self._rates, self._rounds = rates, rounds

    def measure(self, size: float, progress: Progress) -> Result:
        """Measure all sides in turn at each rate."""
        rounds = max(round(self._rounds * min(4 * size, 1)), 1)
        off: dict[int, list[float]] = {rate: [] for rate in self._rates}
        sides = {
            rate: _sides(rate, max(full * size, 1.0), off[rate], progress)
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
            tables=(_times(found), _costs(found), *work_table(found)),
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
        """Draw the answers' times."""
        from bench.drawing import answer_times

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
        return (answer_times(curves, folder / "loop.png"),)


def _sides(
    rate: int, seconds: float, off: list[float], progress: Progress
) -> dict[str, Callable[[], Measurement]]:
    """Return what measures each side at a rate [Hz], for so long [s].

    off: where to say how far off its goal our hand was at worst [m]
    """

    def ours(*, every_state: bool = False) -> Measurement:
        period = "60 ms" if rate == 17 else f"{1e3 / rate:g} ms"
        name = f"robot=bench-loop-{rate}"
        deployment = deployed(ARPH, name, f"period={period}", "plant.hold=240 ms")
        told = run_msma(deployment, seconds, every_state=every_state)
        off.append(told.error)
        return told.measured

    def amid() -> Measurement:
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
    if rate in DETAILED:
        sides[DECIDING] = lambda: run_plain(hertz, seconds, decides=True)
        sides[EVERY_STATE] = lambda: ours(every_state=True)
        sides[BUSY] = amid
    return {side: shown(side, measure) for side, measure in sides.items()}


def run_plain(rate: float, seconds: float, *, decides: bool = False) -> Measurement:
    """Let plain Zenoh echo, in as many processes as ours, each of which also `decides` if so."""
    port = free_port()
    program = "bench.echo.deciding_zenoh" if decides else "bench.echo.plain_zenoh"
    return run_side(
        {role: [program, *to_args(EchoSpec(role, rate, seconds, port))] for role in ROLES},
        seconds,
    )


def _checks(rate: int, sides: Runs, off: float) -> list[Check]:
    checks = [
        Check(
            f"{rate} Hz, {OURS}: hand off its goal at worst", f"{1e3 * off:.2f} mm", off < MOST_OFF
        )
    ]
    for side, runs in sides.items():
        told = min(run.ticks["ticks"] / (run.ticks["ticks"] + run.ticks["missed"]) for run in runs)
        silent = [
            role for run in runs for role, answers in run.ticks["heard"].items() if not answers
        ]
        text = f"{100 * told:.2f} % told, all answer" if not silent else f"no answer: {silent}"
        # how many are told and answered in time is a figure: at 2 kHz it says where it ends
        checks.append(Check(f"{rate} Hz, {side}: ticks told", text, not silent))
    return checks


def bars(found: Mapping[int, Runs]) -> list[Row]:
    """Return what was to be reached; where it is a matter of time, beside what can be."""
    rows = []
    if 1000 in found:
        slower = _slower(found[1000], OURS)
        words = f"{slower.text()}; {DECIDING}: {_slower(found[1000], DECIDING).text()}"
        rows += [
            _answered(1000, found[1000], 0.999),
            Row("1 kHz: p99 beside plain Zenoh", "at most 1.5 x", words, slower.median <= 1.5),
        ]
    if 500 in found:
        cores = {side: median(run.cores for run in runs) for side, runs in found[500].items()}
        words = _beside({side: f"{each:.2f} cores" for side, each in cores.items()})
        rows += [
            _answered(500, found[500], 0.9999),
            Row("500 Hz: all processes together", "under 1 core", words, cores[OURS] < 1),
        ]
    if 17 in found:
        used = [usage for run in found[17][OURS] for usage in run.usage.values()]
        cpu, pss = max(usage.cpu for usage in used), max(usage.pss for usage in used)
        cost, size = f"{100 * cpu:.1f} %", f"{pss / 1e6:.1f} MB (PSS)"
        rows += [
            Row("60 ms: processor of each process", "under 5 % of a core", cost, cpu < 0.05),
            Row("60 ms: memory of each process", "under 60 MB", size, pss < 60e6),
        ]
    return rows


def _slower(sides: Runs, side: str) -> Ratio:
    times = {each: [run.time("p99") for run in sides[each]] for each in (side, PLAIN)}
    return ratio(times[side], times[PLAIN])


def _answered(rate: int, sides: Runs, bar: float) -> Row:
    words = {}
    for side, runs in sides.items():
        due = _due(runs)
        late = due - _in_time(runs)
        words[side] = f"{100 * (1 - late / due):.3f} % (all but {late} of {due})"
    what = f"{rate} Hz: answered by all in the period"
    held = _in_time(sides[OURS]) >= bar * _due(sides[OURS])
    return Row(what, f"{100 * bar:g} %", _beside(words), held)


def _beside(figures: Mapping[str, str]) -> str:
    """Return our figure, and by name those that say what there is to be had."""
    others = [f"{side}: {figure}" for side, figure in figures.items() if side != OURS]
    return "; ".join((figures[OURS], *others))


def _in_time(runs: Sequence[Measurement]) -> int:
    return sum(int(run.ticks["in_time"]) for run in runs)


def _due(runs: Sequence[Measurement]) -> int:
    return sum(int(run.ticks["ticks"] + run.ticks["missed"]) for run in runs)


def _times(found: Mapping[int, Runs]) -> Table:
    rows = []
    for rate, sides in found.items():
        for side, runs in sides.items():
            times = [
                f"{1e3 * median(run.time(which) for run in runs):.2f}"
                for which in ("p50", "p99", "p999", "worst")
            ]
            beside = [
                ratio([run.time(which) for run in runs], [run.time(which) for run in sides[PLAIN]])
                for which in ("p50", "p99")
            ]
            rows.append((f"{rate} Hz", side, *times, f"{100 * _in_time(runs) / _due(runs):.3f} %",
                         *(each.text() if side != PLAIN else "" for each in beside)))  # fmt: skip
    head = ("rate", "side", "p50 [ms]", "p99", "p99.9", "max", "all in time",
            "p50 beside plain", "p99 beside plain")  # fmt: skip
    return Table("from state to command, at the plant", head, tuple(rows))


def _costs(found: Mapping[int, Runs]) -> Table:
    rows = []
    for rate, sides in found.items():
        for side, runs in sides.items():
            cells = []
            for group in (("plant",), ("goal",), ROLES[2:]):
                used = [run.usage[role] for run in runs for role in group]
                cells.append(f"{100 * median(usage.cpu for usage in used):.1f} %")
            every = [usage for run in runs for usage in run.usage.values()]
            rows.append((
                f"{rate} Hz", side, *cells, f"{median(run.cores for run in runs):.2f}",
                f"{max(usage.pss for usage in every) / 1e6:.1f}",
                f"{max(usage.rss for usage in every) / 1e6:.1f}",
                f"{max(usage.threads for usage in every)}",
            ))  # fmt: skip
    head = ("rate", "side", "plant: cpu", "goal", "an agent", "all: cores",
            "largest PSS [MB]", "RSS [MB]", "threads")  # fmt: skip
    return Table("what the processes cost", head, tuple(rows))


def work_table(found: Mapping[int, Runs]) -> list[Table]:
    """Return what reading, deciding and telling take a tick, alone and among all others."""
    rates = [rate for rate in found if rate in DETAILED]
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
    head = ("process", "again and again, alone", *(f"at {rate} Hz, among all" for rate in rates))
    return [Table("reading, thinking and writing, in us of a processor a tick", head, tuple(rows))]


def _alone(think: Callable[[], object]) -> float:
    """Return how long it takes a processor [s] that does nothing else, and has for a while."""
    for _ in range(_THOUGHTS):
        think()
    begun = time.thread_time()
    for _ in range(_THOUGHTS):
        think()
    return (time.thread_time() - begun) / _THOUGHTS


NOTES = (
    "Each round starts all processes of each side anew; times are medians over the rounds, shares "
    "are of all their ticks, ratios are of the two sides in the same round (least to most).",
    "Plain Zenoh has the same sessions, keys, sizes and number of processes; its agents send the "
    "number of the tick back and do nothing else.",
    "Our agents answer every state, and decide 100 times a second at most: in between they answer "
    "with what they decided last, for within a twelfth of its horizon their law comes to the same. "
    "They answer first, and decide then, so that no answer waits for a decision. "
    f"'{EVERY_STATE}' has both left out.",
    "Plain Zenoh that reads and decides does in each agent what our agent's law does for a "
    "decision, as often as ours, on percepts that were recorded, and a step of the simulation in "
    "the plant, and each reads and writes the messages of the wire contract that this takes at the "
    "least. So it is what is to be had for as many processes with these laws and messages. Ours "
    "hold each message against who else speaks in that role, put percepts together and log, too. "
    "What it takes more of a processor per tick than the plain echo is what it reads, thinks and "
    "writes among all others.",
    "All processes of all sides ask to be scheduled in real time, as ours do in a launch. Where "
    "that is not granted, programs on all cores hold a robot up. Where it is, they help: a core "
    "that is never idle need not be woken, which takes long where the machine is virtual.",
    "A tick counts as answered in time when the commands of all seven have arrived within its "
    "period at the process that told it, by that process's clock. Ticks that it was too late to "
    "tell count as not answered.",
)
