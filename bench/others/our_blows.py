"""How long the commands that our plant obeys stay away after something of ours was killed."""

import subprocess
import sys
import tempfile
import time
from pathlib import Path

from bench.bench import BenchError
from bench.echo.load import AGENTS
from bench.echo.side import environment
from bench.others.blows import PERIOD, Struck, judged
from bench.others.systems import VICTIM
from bench.ours import ARPH
from runtime.launching.gaps import arrivals
from runtime.launching.record import RecordError, read_log, read_record
from runtime.wire.keys import PLANT

_AT = (3.0, 6.0, 9.0)  # [s, plant time] of the blows
_WATCHED = 2.0  # [s]
_LASTS = 12.5  # [s]
_PATIENCE = 40.0  # [s] for a run to begin and to end
_STANDS_BY = "joint/3"
_BLOWS = (
    ("an agent; started again at once", VICTIM),
    ("an agent; a copy stands by (`copies: 2`)", _STANDS_BY),
    ("the launcher; nothing started again", None),
)


def strike_ours() -> list[Struck]:
    """Launch our robot at 60 ms, deal it blows, and return what each did."""
    first, second, third = _AT
    words = [
        *("launch", str(ARPH), "--robot", "bench-blows", "--duration", f"{_LASTS:g}s"),
        *("--set", f"agents.{_STANDS_BY}.copies=2"),
        *("--kill", f"{VICTIM}@{first:g}", "--revive", f"{VICTIM}@{first:g}"),
        *("--kill", f"{_STANDS_BY}@{second:g}", "--kill", f"launcher@{third:g}"),
    ]
    with tempfile.TemporaryDirectory(prefix="msma-", ignore_cleanup_errors=True) as place:
        launcher = subprocess.Popen(
            [sys.executable, "-P", "-m", "runtime.cli", *words],
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            cwd=place,
            env=environment(),
        )
        until = time.monotonic() + _PATIENCE
        while not (run := _ended(Path(place))) or launcher.poll() is None:
            if time.monotonic() > until:
                launcher.kill()
                raise BenchError(f"a run of ours did not end in {_PATIENCE:g} s")
            time.sleep(0.1)
        return _judge(run)


def _ended(place: Path) -> Path | None:
    """Return the folder of the run once its plant has ended."""
    for run in place.glob("runs/*"):
        if any(line["event"] == "end" for line in read_log(run, PLANT)):
            return run
    return None


def _judge(run: Path) -> list[Struck]:
    try:
        found = arrivals(read_record(run), PERIOD)
    except RecordError as error:
        raise BenchError(f"a run of ours left nothing to look at: {error}") from error
    obeyed = {role: times.tolist() for role, times in zip(AGENTS, found, strict=True)}
    chaos = [line for log in ("launcher", "heir") for line in read_log(run, log)]
    kills = [line["t"] for line in chaos if line["event"] == "chaos" and line["action"] == "kill"]
    if len(kills) != len(_BLOWS):
        raise BenchError(f"{len(kills)} kills in a run of ours, not {len(_BLOWS)}")
    return [
        judged(what, role, obeyed, since, since + _WATCHED)
        for (what, role), since in zip(_BLOWS, kills, strict=True)
    ]
