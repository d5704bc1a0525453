"""How long the plant goes without a new command when any one process is killed, or hangs."""

from collections.abc import Sequence
from itertools import product
from pathlib import Path
from typing import NamedTuple

from bench.bench import Bench, Check, Result, Table
from bench.launched import launched
from bench.msma_runs import ARPH, deployed
from runtime.results.gaps import arrivals, longest
from runtime.results.run_log import RunLog, read_run_log
from runtime.wire.topics import GOAL_SOURCE, PLATFORM_AGENT
from studies.study import Progress, Row

ROUNDS = 2
FIRST, APART, LOOKED_AT = 3.0, 1.5, 1.2
"""When the first process is hit, from one to the next, and how long is looked at [s]."""
HANGING = 0.8
"""How long each hangs that is stopped [s]: till long after the others have given it up."""
BLOWS = {"kill": "SIGKILL", "hang": "SIGSTOP"}
LAUNCHER = "launcher"


class FaultGap(NamedTuple):
    """A process was hit.

    kill: kill or hang
    own: the longest gap in the commands of its role just then, by its stand-by [s]; None for a
        role that commands nothing
    others: the longest gap in anybody else's [s]
    """

    kill: str
    victim: str
    own: float | None
    others: float


class GapBench(Bench):
    """SIGKILL to each process in turn, and SIGSTOP, while every agent has one that stands by."""

    name = "gap"
    title = "The gap in commands after a SIGKILL or SIGSTOP of any one process"

    def __init__(self, rounds: int = ROUNDS, chaos_targets: Sequence[str] | None = None) -> None:
        """FaultGap each of these processes that often, by default all but the plant."""
        roles = [agent.role for agent in deployed(ARPH).agents]
        self._rounds, self._victims = rounds, chaos_targets or [GOAL_SOURCE, *roles, LAUNCHER]

    def measure(self, size: float, progress: Progress) -> Result:
        """FaultGap one after the other, every one of them in each round."""
        rounds = max(round(self._rounds * size), 1)
        progress.begin(rounds * len(BLOWS))
        period = deployed(ARPH).period
        hits: list[FaultGap] = []
        done = []
        quiet = 0.0
        for number, kill in product(range(rounds), BLOWS):
            progress.step(f"round {number + 1}, {kill}")
            found, record, count = _round(kill, period, self._victims)
            hits += found
            done.append((f"round {number + 1}: processes hit by {BLOWS[kill]}", count))
            times = arrivals(record, period)
            quiet = max(quiet, *(longest(each, FIRST - APART, FIRST - 0.2) for each in times))
        return Result(
            checks=tuple(
                Check(what, f"{count}", count == len(self._victims)) for what, count in done
            ),
            bars=(
                _bar("any one process killed", "kill", hits, period),
                _bar("any one process stopped", "hang", hits, period),
            ),
            tables=tuple(_table(kill, hits, period, quiet) for kill in BLOWS),
            notes=NOTES,
            data={"period_s": period, "quiet_s": quiet, "hits": [hit._asdict() for hit in hits]},
        )

    def draw(self, result: Result, folder: Path) -> tuple[Path, ...]:
        """Draw the longest gap after each hit."""
        from bench.drawing import bars

        worst: dict[str, float] = {}
        for hit in result.data["hits"]:
            gap = max(hit["own"] or 0.0, hit["others"]) / result.data["period_s"]
            name = f"{hit['victim']}, {BLOWS[hit['kill']]}"
            worst[name] = max(gap, worst.get(name, 0.0))
        return (bars(worst, "longest gap in anybody's commands [periods]", folder / "gap.png"),)


def _round(
    kill: str, period: float, chaos_targets: Sequence[str]
) -> tuple[list[FaultGap], RunLog, int]:
    """Launch, hit each process in turn, and return what that did, and how many were hit."""
    roles = [agent.role for agent in deployed(ARPH).agents]
    at = {victim: FIRST + APART * index for index, victim in enumerate(chaos_targets)}
    duration = FIRST + APART * len(chaos_targets)
    words = [str(ARPH), "--robot", f"bench-gap-{kill}", "--duration", f"{duration:g} s"]
    for role in roles:
        words += ["--set", f"agents.{role}.copies=2"]
    for victim, t in at.items():
        lasting = f":{HANGING:g}s" if kill == "hang" else ""
        words += [f"--{kill}", f"{victim}@{t:g}{lasting}"]
    with launched(words) as run:
        run.end(duration)
        record = read_run_log(run.run)
        done = [line for line in run.log(LAUNCHER) if line.get("action") == kill]
    times = dict(zip((*(r for r in roles if r != PLATFORM_AGENT), PLATFORM_AGENT),
                     arrivals(record, period), strict=True))  # fmt: skip
    hits = []
    for victim, t in at.items():
        gaps = {role: longest(each, t, t + LOOKED_AT) for role, each in times.items()}
        others = max(gap for role, gap in gaps.items() if role != victim)
        hits.append(FaultGap(kill, victim, gaps.get(victim), others))
    return hits, record, len(done)


def _bar(what: str, kill: str, hits: Sequence[FaultGap], period: float) -> Row:
    worst = max(max(hit.own or 0.0, hit.others) for hit in hits if hit.kill == kill)
    found = f"{worst / period:.2f} periods ({1e3 * worst:.0f} ms)"
    return Row(f"gap in commands, {what}", "at most 2 periods", found, worst <= 2 * period)


def _table(kill: str, hits: Sequence[FaultGap], period: float, quiet: float) -> Table:
    def cell(seconds: list[float]) -> str:
        if not seconds:
            return "commands nothing"
        worst = max(seconds)
        return f"{worst / period:.2f} ({1e3 * worst:.0f} ms)"

    rows = [("nobody", "", cell([quiet]))]
    for victim in dict.fromkeys(hit.victim for hit in hits):
        its = [hit for hit in hits if (hit.kill, hit.victim) == (kill, victim)]
        own = cell([hit.own for hit in its if hit.own is not None])
        rows.append((victim, own, cell([hit.others for hit in its])))
    head = (BLOWS[kill], "its own role's commands, periods", "anybody else's, periods")
    return Table(f"the longest gap just after a {BLOWS[kill]}", head, tuple(rows))


NOTES = (
    "Every agent runs twice: one is obeyed, the other stands by. It is the obeyed one that is "
    "hit. Gaps are between two commands that the plant obeyed, by its own clock.",
    "The plant is the robot itself: without it there is nobody to command.",
)
