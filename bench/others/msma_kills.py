"""The gap in the commands that MSMA's plant executes after one of its processes is killed."""

from bench.bench import BenchError
from bench.echo.workload import AGENTS
from bench.launched import Launched, launched
from bench.msma_runs import ARPH
from bench.others.kills import PERIOD, KillImpact, impact_of
from bench.others.systems import VICTIM
from runtime.results.run_log import RunLogError, read_run_log

_AT = (2.0, 4.5, 7.0)  # [s, plant time] of the kills
_OBSERVED = 2.0  # [s] after each kill
_DURATION = 10.0  # [s]
_WITH_STANDBY = "joint/3"
_KILLS = (
    ("an agent, restarted at once", VICTIM),
    ("an agent with a standby (`copies: 2`)", _WITH_STANDBY),
    ("the launcher, not restarted", None),
)


def measure_msma_kills() -> list[KillImpact]:
    """Launch the robot at 60 ms, kill some of its processes, and return the effect of each kill."""
    first, second, third = _AT
    options = [
        *(str(ARPH), "--robot", "bench-kills", "--duration", f"{_DURATION:g}s"),
        *("--set", f"agents.{_WITH_STANDBY}.copies=2"),
        *("--kill", f"{VICTIM}@{first:g}", "--revive", f"{VICTIM}@{first:g}"),
        *("--kill", f"{_WITH_STANDBY}@{second:g}", "--kill", f"launcher@{third:g}"),
    ]
    with launched(options) as run:
        run.end(_DURATION)
        return _impacts(run)


def _impacts(run: Launched) -> list[KillImpact]:
    try:
        found = read_run_log(run.run).arrivals(PERIOD)
    except RunLogError as error:
        raise BenchError(f"a run of MSMA left no usable log: {error}") from error
    executed = {role: times.tolist() for role, times in zip(AGENTS, found, strict=True)}
    kills = [line["t"] for line in run.log("launcher") if line.get("action") == "kill"]
    if len(kills) != len(_KILLS):
        raise BenchError(f"{len(kills)} kills in a run of MSMA, not {len(_KILLS)}")
    return [
        impact_of(what, role, executed, since, since + _OBSERVED)
        for (what, role), since in zip(_KILLS, kills, strict=True)
    ]
