"""The report of a campaign, as text, Markdown and JSON."""

import json
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from statistics import median

from runtime.campaign.campaign import CampaignRun
from runtime.config.chaos import ChaosEvent
from runtime.config.deployment import Deployment
from runtime.watching.roster import order
from runtime.watching.table import columns, distance, off

_Z = 1.959964  # quantile of the normal distribution for a 95 % interval

Line = tuple[str, str, str, str]
"""A line of the report: what was measured, its median, its worst value, and the sample size."""
HEADINGS: Line = ("", "median", "worst", "of")


def wilson(successes: int, count: int) -> tuple[float, float]:
    """Return the bounds of the 95 % interval of a share, 0 to 1, after E. B. Wilson (1927)."""
    if count == 0:
        return 0.0, 1.0
    share, weight = successes / count, _Z * _Z / count
    middle = share + weight / 2
    half = _Z * math.sqrt(share * (1 - share) / count + weight / (4 * count))
    return max((middle - half) / (1 + weight), 0.0), min((middle + half) / (1 + weight), 1.0)


@dataclass(frozen=True)
class CampaignReport:
    """A campaign and what it measured; `command` repeats a run, but for its seed."""

    deployment: Deployment
    runs: Sequence[CampaignRun]
    command: str

    @property
    def headline(self) -> str:
        """How many runs reached the goal."""
        reached, count = self._count("reached"), len(self.runs)
        low, high = wilson(reached, count)
        share = f"{100 * reached / count:.1f} %" if count else "none"
        turns = any(run.angle for run in self.runs)
        within = f"within {off(*self.deployment.tolerance.limits(turns))}"
        return (
            f"{reached} of {count} runs ended {within} of the goal: {share}, "
            f"95 % interval {100 * low:.1f} to {100 * high:.1f} %"
        )

    def lines(self) -> list[Line]:
        """Return what was measured; without lines that have no samples."""
        faults = [fault for run in self.runs for fault in run.impact.faults]
        killed, hung = ([f for f in faults if f.action == action] for action in ("kill", "hang"))
        angles = (run.angle or None for run in self.runs)
        lines = [
            _line("error at the end", (run.error for run in self.runs), distance),
            _line("angle at the end", angles, lambda angle: f"{math.degrees(angle):.2f} deg"),
            self._gaps("gap in other agents' commands after a kill", (f.gap for f in killed)),
            self._gaps("gap in other agents' commands after a hang", (f.gap for f in hung)),
            _line("time until a kill was detected", (f.detected for f in killed), _ms),
            _line("time until a hang was detected", (f.detected for f in hung), _ms),
            _line("restart until the first accepted command", (f.recovery for f in killed), _ms),
            _line("SIGCONT until the first accepted command", (f.recovery for f in hung), _ms),
            self._gaps("gap until a standby took over", (f.silence for f in faults if f.standbys)),
        ]
        for role in sorted({role for run in self.runs for role in run.impact.gaps}, key=order):
            gaps = (run.impact.gaps.get(role) for run in self.runs)
            lines.append(self._gaps(f"{role}: longest gap while alive", gaps))
        kinds = {(f.action, f.role) for f in faults}
        for action, role in sorted(kinds, key=lambda kind: (kind[0], order(kind[1]))):
            error = (f.error for f in faults if (f.action, f.role) == (action, role))
            lines.append(_line(f"error in the 3 s after a {action} of {role}", error, distance))
        return [line for line in lines if line[3] != "0"]

    def failures(self) -> list[str]:
        """Return a line for each run that did not reach the goal, with the command to repeat it."""
        missed = (run for run in self.runs if run.outcome != "reached")
        return [f"{_sentence(run)}; repeat: {self._command(run)}" for run in missed]

    def text(self) -> str:
        """Return the report for a terminal."""
        table = columns([HEADINGS, *self.lines()])
        return "\n".join([self.headline, *(f"  {line}" for line in table), *self.failures()])

    def markdown(self) -> str:
        """Return the report as a page."""
        head = f"# Chaos: {self.deployment.robot}, {len(self.runs)} runs\n\n{self.headline}.\n"
        table = [HEADINGS, ("---",) * 4, *self.lines()]
        rows = "\n".join(f"| {' | '.join(row)} |" for row in table)
        runs = "\n".join(
            f"- {_sentence(run)}: {as_options(run.chaos)} (`--seed {run.seed}`)"
            for run in self.runs
        )
        missed = "\n".join(f"- {line}" for line in self.failures()) or "None."
        return (
            f"{head}\nTo repeat a run: `{self.command} --seed N`.\n\n{rows}\n\n"
            f"## Runs that did not reach the goal\n\n{missed}\n\n## All runs\n\n{runs}\n"
        )

    def to_json(self) -> str:
        """Return the report for programs, in SI units."""
        runs = []
        for run in self.runs:
            chaos = [as_options([event]) for event in run.chaos]
            runs.append(asdict(run) | {"chaos": chaos, "command": self._command(run)})
        plain = {
            "robot": self.deployment.robot,
            "count": len(self.runs),
            **{outcome: self._count(outcome) for outcome in ("reached", "missed", "failed")},
            "interval": wilson(self._count("reached"), len(self.runs)),
            "runs": runs,
        }
        return json.dumps(plain, indent=2, default=str) + "\n"

    def _count(self, outcome: str) -> int:
        return sum(run.outcome == outcome for run in self.runs)

    def _command(self, run: CampaignRun) -> str:
        return f"{self.command} --seed {run.seed}"

    def _gaps(self, what: str, gaps: Iterable[float | None]) -> Line:
        """Return the line for gaps [s, plant time], in control periods and ms."""
        period = self.deployment.period
        return _line(what, gaps, lambda gap: f"{gap / period:.2f} periods ({1e3 * gap:.0f} ms)")


def as_options(events: Iterable[ChaosEvent]) -> str:
    """Return chaos events as the command-line options that schedule them."""
    options = []
    for event in events:
        lasting = "" if event.for_ is None else f":{event.for_:g}s"
        options.append(f"--{event.action} {event.target}@{event.at:g}{lasting}")
    return " ".join(options)


def _sentence(run: CampaignRun) -> str:
    end = f"{off(run.error, run.angle)} off at the end"
    return f"seed {run.seed} {run.outcome}: {run.reason or end}"


def _ms(time: float) -> str:
    return f"{1e3 * time:.0f} ms"


def _line(what: str, values: Iterable[float | None], written: Callable[[float], str]) -> Line:
    found = [value for value in values if value is not None]
    if not found:
        return (what, "", "", "0")
    return (what, written(median(found)), written(max(found)), str(len(found)))
