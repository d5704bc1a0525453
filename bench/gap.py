"""The gap in the commands at the plant after any one process is killed or hangs."""

from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import NamedTuple

import numpy as np

from agents.agent import Array
from bench.bench import Bench, Check, Result, Table
from bench.launched import launched
from bench.msma_runs import ARPH, deployed
from runtime.results.run_log import RunLog, read_run_log
from runtime.wire.topics import GOAL_SOURCE, PLATFORM_AGENT
from studies.study import Progress, Row

ROUNDS = 2
FIRST, APART, OBSERVED = 3.0, 1.5, 1.2
"""Time of the first fault, time between faults, and time observed after each [s]."""
LATE = 3.0
"""How much later the last fault may be, on a machine that starves the launcher [s]."""
HANGING = 0.8
"""How long a stopped process hangs [s]: until well after its standby has taken over."""
SIGNALS = {"kill": "SIGKILL", "hang": "SIGSTOP"}
LAUNCHER = "launcher"


class FaultGap(NamedTuple):
    """The gaps after one fault.

    Attributes:
        fault: `kill` or `hang`.
        victim: Role of the process.
        own: Longest gap in the commands of that role, before and with its standby [s]; None for a
            role without commands.
        others: Longest gap in the commands of all other roles [s].
    """

    fault: str
    victim: str
    own: float | None
    others: float


def longest(times: Array, since: float, until: float) -> float:
    """Return the longest gap between arrival `times` that overlaps `since` to `until`, all [s].

    The gap after the last arrival counts, up to `until`.
    """
    first = max(int(np.searchsorted(times, since, side="right")) - 1, 0)
    last = int(np.searchsorted(times, until, side="left"))
    seen = times[first : last + 1]
    if len(seen) == 0 or seen[-1] < until:
        seen = np.append(seen, until)
    if seen[0] > since:
        seen = np.append(since, seen)
    return float(np.diff(seen).max(initial=0.0))


class GapBench(Bench):
    """SIGKILL, and then SIGSTOP, to each process in turn, while every agent has a standby."""

    name = "gap"
    title = "The gap in commands after a SIGKILL or SIGSTOP of any one process"

    def __init__(self, rounds: int = ROUNDS, chaos_targets: Sequence[str] | None = None) -> None:
        """Kill and stop these processes, by default all but the plant, once in each round."""
        roles = [agent.role for agent in deployed(ARPH).agents]
        self._rounds, self._victims = rounds, chaos_targets or [GOAL_SOURCE, *roles, LAUNCHER]

    def measure(self, size: float, progress: Progress) -> Result:
        """Kill all processes one after the other, then stop them, in each round."""
        rounds = max(round(self._rounds * size), 1)
        progress.begin(rounds * len(SIGNALS))
        period = deployed(ARPH).period
        gaps_after: list[FaultGap] = []
        done = []
        quiet = 0.0
        for number, fault in product(range(rounds), SIGNALS):
            progress.step(f"round {number + 1}, {fault}")
            found, record, count = _round(fault, period, self._victims)
            gaps_after += found
            done.append((f"round {number + 1}: processes that got {SIGNALS[fault]}", count))
            times = record.arrivals(period)
            quiet = max(quiet, *(longest(each, FIRST - APART, FIRST - 0.2) for each in times))
        return Result(
            checks=tuple(
                Check(what, f"{count}", count == len(self._victims)) for what, count in done
            ),
            bars=(
                _bar("any one process killed", "kill", gaps_after, period),
                _bar("any one process stopped", "hang", gaps_after, period),
            ),
            tables=tuple(_table(fault, gaps_after, period, quiet) for fault in SIGNALS),
            notes=NOTES,
            data={
                "period_s": period,
                "quiet_s": quiet,
                "gaps": [each._asdict() for each in gaps_after],
            },
        )

    def draw(self, result: Result, folder: Path) -> tuple[Path, ...]:
        """Draw the longest gap after each fault."""
        from bench.drawing import bars

        worst: dict[str, float] = {}
        for each in result.data["gaps"]:
            gap = max(each["own"] or 0.0, each["others"]) / result.data["period_s"]
            name = f"{each['victim']}, {SIGNALS[each['fault']]}"
            worst[name] = max(gap, worst.get(name, 0.0))
        return (
            bars(worst, "longest gap in the commands of any role [periods]", folder / "gap.png"),
        )


def _round(
    fault: str, period: float, chaos_targets: Sequence[str]
) -> tuple[list[FaultGap], RunLog, int]:
    """Launch, apply the fault to each process in turn, and return the gaps, log and fault count."""
    roles = [agent.role for agent in deployed(ARPH).agents]
    at = {victim: FIRST + APART * index for index, victim in enumerate(chaos_targets)}
    duration = FIRST + APART * len(chaos_targets) + LATE
    options = [str(ARPH), "--robot", f"bench-gap-{fault}", "--duration", f"{duration:g} s"]
    for role in roles:
        options += ["--set", f"agents.{role}.copies=2"]
    for victim, t in at.items():
        lasting = f":{HANGING:g}s" if fault == "hang" else ""
        options += [f"--{fault}", f"{victim}@{t:g}{lasting}"]
    with launched(options) as run:
        run.end(duration)
        record = read_run_log(run.run)
        done = {
            each["target"]: each["t"] for each in run.log(LAUNCHER) if each.get("action") == fault
        }
    times = dict(zip((*(r for r in roles if r != PLATFORM_AGENT), PLATFORM_AGENT),
                     record.arrivals(period), strict=True))  # fmt: skip
    gaps_after = []
    for victim, t in done.items():
        gaps = {role: longest(each, t, t + OBSERVED) for role, each in times.items()}
        others = max(gap for role, gap in gaps.items() if role != victim)
        gaps_after.append(FaultGap(fault, victim, gaps.get(victim), others))
    return gaps_after, record, len(done)


def _bar(what: str, fault: str, gaps_after: Sequence[FaultGap], period: float) -> Row:
    worst = max(max(each.own or 0.0, each.others) for each in gaps_after if each.fault == fault)
    found = f"{worst / period:.2f} periods ({1e3 * worst:.0f} ms)"
    return Row(f"gap in commands, {what}", "at most 2 periods", found, worst <= 2 * period)


def _table(fault: str, gaps_after: Sequence[FaultGap], period: float, quiet: float) -> Table:
    def cell(seconds: list[float]) -> str:
        if not seconds:
            return "no commands"
        worst = max(seconds)
        return f"{worst / period:.2f} ({1e3 * worst:.0f} ms)"

    rows = [("none", "", cell([quiet]))]
    for victim in dict.fromkeys(each.victim for each in gaps_after):
        its = [each for each in gaps_after if (each.fault, each.victim) == (fault, victim)]
        own = cell([each.own for each in its if each.own is not None])
        rows.append((victim, own, cell([each.others for each in its])))
    head = (SIGNALS[fault], "commands of its role [periods]", "of all other roles [periods]")
    return Table(f"longest gap after a {SIGNALS[fault]}", head, tuple(rows))


NOTES = (
    "Every agent runs twice: the plant executes the commands of one process, the other is its "
    "standby. The fault hits the former. A gap is the time between two commands that the plant "
    "executed, by its own clock.",
    "The plant is the robot itself: without it there is nothing to command.",
)
