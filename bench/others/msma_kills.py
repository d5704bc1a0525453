"""How long the commands that our plant obeys stay away after something of ours was killed."""

from bench.bench import BenchError
from bench.echo.workload import AGENTS
from bench.launched import Launched, launched
from bench.msma_runs import ARPH
from bench.others.kills import PERIOD, KillImpact, judged
from bench.others.systems import VICTIM
from runtime.results.gaps import arrivals
from runtime.results.run_log import RunLogError, read_run_log

_AT = (2.0, 4.5, 7.0)  # [s, plant time] of the blows
_WATCHED = 2.0  # [s]
_LASTS = 10.0  # [s]
_STANDS_BY = "joint/3"
_BLOWS = (
    ("an agent; started again at once", VICTIM),
    ("an agent; a copy stands by (`copies: 2`)", _STANDS_BY),
    ("the launcher; nothing started again", None),
)


def strike_ours() -> list[KillImpact]:
    """Launch our robot at 60 ms, deal it blows, and return what each did."""
    first, second, third = _AT
    words = [
        *(str(ARPH), "--robot", "bench-blows", "--duration", f"{_LASTS:g}s"),
        *("--set", f"agents.{_STANDS_BY}.copies=2"),
        *("--kill", f"{VICTIM}@{first:g}", "--revive", f"{VICTIM}@{first:g}"),
        *("--kill", f"{_STANDS_BY}@{second:g}", "--kill", f"launcher@{third:g}"),
    ]
    with launched(words) as run:
        run.end(_LASTS)
        return _judge(run)


def _judge(run: Launched) -> list[KillImpact]:
    try:
        found = arrivals(read_run_log(run.run), PERIOD)
    except RunLogError as error:
        raise BenchError(f"a run of ours left nothing to look at: {error}") from error
    obeyed = {role: times.tolist() for role, times in zip(AGENTS, found, strict=True)}
    kills = [line["t"] for line in run.log("launcher") if line.get("action") == "kill"]
    if len(kills) != len(_BLOWS):
        raise BenchError(f"{len(kills)} kills in a run of ours, not {len(_BLOWS)}")
    return [
        judged(what, role, obeyed, since, since + _WATCHED)
        for (what, role), since in zip(_BLOWS, kills, strict=True)
    ]
