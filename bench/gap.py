"""How long the plant goes without a new command when any one process is killed."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from bench.bench import Bench, Check, Result, Table
from bench.launched import launched
from bench.ours import ARPH, deployed
from runtime.launching.gaps import arrivals, longest
from runtime.launching.record import Record, read_record
from runtime.wire.keys import GOAL_SOURCE, PLATFORM_AGENT
from studies.study import Row, Watch

ROUNDS = 2
FIRST, APART, LOOKED_AT = 3.0, 1.5, 1.2
"""When the first process is killed, from one to the next, and how long is looked at [s]."""
LAUNCHER = "launcher"


class Hit(NamedTuple):
    """A process was killed.

    own: the longest gap in the commands of its role just then, by its stand-by [s]; None for a
        role that commands nothing
    others: the longest gap in anybody else's [s]
    """

    victim: str
    own: float | None
    others: float


class GapBench(Bench):
    """SIGKILL to each process in turn, while every agent has one that stands by."""

    name = "gap"
    title = "The gap in commands after a SIGKILL of any one process"

    def __init__(self, rounds: int = ROUNDS, victims: Sequence[str] | None = None) -> None:
        """Kill each of these processes that often, by default all but the plant."""
        roles = [agent.role for agent in deployed(ARPH).agents]
        self._rounds, self._victims = rounds, victims or [GOAL_SOURCE, *roles, LAUNCHER]

    def measure(self, size: float, watch: Watch) -> Result:
        """Kill one after the other, every one of them in each round."""
        rounds = max(round(self._rounds * size), 1)
        watch.expect(rounds)
        period = deployed(ARPH).period
        hits: list[Hit] = []
        killed = []
        quiet = 0.0
        for number in range(rounds):
            watch.at(f"round {number + 1}")
            found, record, count = _round(number, period, self._victims)
            hits += found
            killed.append(count)
            times = arrivals(record, period)
            quiet = max(quiet, *(longest(each, FIRST - APART, FIRST - 0.2) for each in times))
        victims = {hit.victim: [each for each in hits if each.victim == hit.victim] for hit in hits}
        worst = max(max(hit.own or 0.0, hit.others) for hit in hits)
        bar = f"{worst / period:.2f} periods ({1e3 * worst:.0f} ms)"
        return Result(
            checks=tuple(
                Check(f"round {number + 1}: processes killed", f"{count}", count == len(victims))
                for number, count in enumerate(killed)
            ),
            bars=(
                Row("gap in commands, any one process killed", "at most 2 periods", bar,
                    worst <= 2 * period),
            ),
            tables=(_table(victims, period, quiet),),
            notes=NOTES,
            data={"period_s": period, "quiet_s": quiet, "hits": [hit._asdict() for hit in hits]},
        )  # fmt: skip

    def draw(self, result: Result, folder: Path) -> tuple[Path, ...]:
        """Draw the longest gap after each kill."""
        from bench.drawing import bars

        worst: dict[str, float] = {}
        for hit in result.data["hits"]:
            gap = max(hit["own"] or 0.0, hit["others"]) / result.data["period_s"]
            worst[hit["victim"]] = max(gap, worst.get(hit["victim"], 0.0))
        return (bars(worst, "longest gap in anybody's commands [periods]", folder / "gap.png"),)


def _round(number: int, period: float, victims: Sequence[str]) -> tuple[list[Hit], Record, int]:
    """Launch, kill each process in turn, and return what that did, and how many died of it."""
    roles = [agent.role for agent in deployed(ARPH).agents]
    at = {victim: FIRST + APART * index for index, victim in enumerate(victims)}
    duration = FIRST + APART * len(victims)
    words = [str(ARPH), "--robot", f"bench-gap-{number}", "--duration", f"{duration:g} s"]
    for role in roles:
        words += ["--set", f"agents.{role}.copies=2"]
    for victim, t in at.items():
        words += ["--kill", f"{victim}@{t:g}"]
    with launched(words) as run:
        run.end(duration)
        record = read_record(run.run)
        kills = [line for line in run.log(LAUNCHER) if line.get("action") == "kill"]
    times = dict(zip((*(r for r in roles if r != PLATFORM_AGENT), PLATFORM_AGENT),
                     arrivals(record, period), strict=True))  # fmt: skip
    hits = []
    for victim, t in at.items():
        gaps = {role: longest(each, t, t + LOOKED_AT) for role, each in times.items()}
        others = max(gap for role, gap in gaps.items() if role != victim)
        hits.append(Hit(victim, gaps.get(victim), others))
    return hits, record, len(kills)


def _table(victims: Mapping[str, list[Hit]], period: float, quiet: float) -> Table:
    def cell(seconds: list[float]) -> str:
        if not seconds:
            return "commands nothing"
        worst = max(seconds)
        return f"{worst / period:.2f} ({1e3 * worst:.0f} ms)"

    rows = [("nobody", "", cell([quiet]))]
    for victim, hits in victims.items():
        own = cell([hit.own for hit in hits if hit.own is not None])
        rows.append((victim, own, cell([hit.others for hit in hits])))
    head = ("killed", "its own role's commands, periods", "anybody else's, periods")
    return Table("the longest gap just after a kill", head, tuple(rows))


NOTES = (
    "Every agent runs twice: one is obeyed, the other stands by. It is the obeyed one that is "
    "killed. Gaps are between two commands that the plant obeyed, by its own clock.",
    "The plant is the robot itself: without it there is nobody to command.",
)
