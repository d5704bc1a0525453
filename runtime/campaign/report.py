"""What a campaign came to: counted and summed up, as text, as Markdown and as JSON."""

import json
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import asdict, dataclass
from statistics import median

from runtime.campaign.campaign import CampaignRun
from runtime.config.chaos import ChaosEvent
from runtime.config.deployment import Deployment
from runtime.watching.roster import order
from runtime.watching.table import columns, distance

_Z = 1.959964  # of the normal distribution, for 95 %

Line = tuple[str, str, str, str]
"""A line of the report: what was measured, its median, its worst, and of how many."""
HEADINGS: Line = ("", "median", "worst", "of")


def wilson(successes: int, count: int) -> tuple[float, float]:
    """Return the 95 % interval of a share by E. B. Wilson (1927): lower and upper bound, 0 to 1."""
    if count == 0:
        return 0.0, 1.0
    share, weight = successes / count, _Z * _Z / count
    middle = share + weight / 2
    half = _Z * math.sqrt(share * (1 - share) / count + weight / (4 * count))
    return max((middle - half) / (1 + weight), 0.0), min((middle + half) / (1 + weight), 1.0)


@dataclass(frozen=True)
class CampaignReport:
    """A campaign.

    Attributes:
        deployment: What was run.
        trials: Each run.
        again: The command without the seed that repeats a run.
    """

    deployment: Deployment
    trials: Sequence[CampaignRun]
    again: str

    @property
    def headline(self) -> str:
        """How many reached the goal."""
        reached, count = self._count("reached"), len(self.trials)
        low, high = wilson(reached, count)
        share = f"{100 * reached / count:.1f} %" if count else "none"
        within = f"within {distance(self.deployment.tolerance)}"
        return (
            f"{reached} of {count} runs ended {within} of the goal: {share}, "
            f"95 % interval {100 * low:.1f} to {100 * high:.1f} %"
        )

    def lines(self) -> list[Line]:
        """Return what was measured."""
        hits = [hit for trial in self.trials for hit in trial.after.hits]
        killed, hung = ([h for h in hits if h.action == action] for action in ("kill", "hang"))
        lines = [
            self._gaps("gap in others' commands, a process killed", (h.gap for h in killed)),
            self._gaps("gap in others' commands, a process hung", (h.gap for h in hung)),
            _times("killed process seen to be gone", (h.noticed for h in killed)),
            _times("hung process seen to be gone", (h.noticed for h in hung)),
            _times("restarted: until obeyed", (h.back for h in killed)),
            _times("woken: until obeyed", (h.back for h in hung)),
        ]
        taken = (h.silence for h in hits if h.standbys)
        lines.append(self._gaps("gap until a standby took over", taken))
        lines += [
            self._gaps(f"{role}: longest gap while alive", self._gaps_of(role))
            for role in self._speakers()
        ]
        for what in sorted({(h.action, h.role) for h in hits}, key=lambda x: (x[0], order(x[1]))):
            error = (h.error for h in hits if (h.action, h.role) == what)
            verb = "killed" if what[0] == "kill" else "hung"
            lines.append(_lengths(f"error in the 3 s after {what[1]} is {verb}", error))
        ends = (trial.error for trial in self.trials)
        return [line for line in [_lengths("error at the end", ends), *lines] if line[3] != "0"]

    def failures(self) -> list[str]:
        """Return a line for each run that did not reach the goal, with what repeats it."""
        return [
            f"{self._sentence(trial)}; again: {self.again} --seed {trial.seed}"
            for trial in self.trials
            if trial.outcome != "reached"
        ]

    def text(self) -> str:
        """Return it for a terminal."""
        table = columns([HEADINGS, *self.lines()])
        return "\n".join(
            [self.headline, *(f"  {line}" for line in table), *self.failures()],
        )

    def markdown(self) -> str:
        """Return it as a page."""
        head = f"# Chaos: {self.deployment.robot}, {len(self.trials)} runs\n\n{self.headline}.\n"
        table = [HEADINGS, ("---",) * 4, *self.lines()]
        rows = "\n".join(f"| {' | '.join(row)} |" for row in table)
        runs = "\n".join(
            f"- {self._sentence(t)}: {faults(t.chaos)} (`--seed {t.seed}`)" for t in self.trials
        )
        missed = "\n".join(f"- {line}" for line in self.failures()) or "None."
        return (
            f"{head}\nA run is repeated by `{self.again} --seed N`.\n\n{rows}\n\n"
            f"## Runs that did not reach the goal\n\n{missed}\n\n## All runs\n\n{runs}\n"
        )

    def to_json(self) -> str:
        """Return all of it, in SI units."""
        low, high = wilson(self._count("reached"), len(self.trials))
        trials = [
            asdict(trial)
            | {
                "run": str(trial.run),
                "chaos": [faults([event]) for event in trial.chaos],
                "again": f"{self.again} --seed {trial.seed}",
            }
            for trial in self.trials
        ]
        plain = {
            "robot": self.deployment.robot,
            "runs": len(self.trials),
            "reached": self._count("reached"),
            "missed": self._count("missed"),
            "failed": self._count("failed"),
            "interval": [low, high],
            "trials": trials,
        }
        return json.dumps(plain, indent=2) + "\n"

    def _count(self, outcome: str) -> int:
        return sum(trial.outcome == outcome for trial in self.trials)

    def _speakers(self) -> list[str]:
        return sorted({role for trial in self.trials for role in trial.after.gaps}, key=order)

    def _gaps_of(self, role: str) -> list[float | None]:
        return [trial.after.gaps.get(role) for trial in self.trials]

    def _sentence(self, trial: CampaignRun) -> str:
        how = trial.why or f"{distance(trial.error)} off at the end"
        return f"seed {trial.seed} {trial.outcome}: {how}"

    def _gaps(self, what: str, gaps: Iterable[float | None]) -> Line:
        """Return gaps [s, plant time] in control periods and ms."""
        found = [gap for gap in gaps if gap is not None]

        def written(gap: float) -> str:
            return f"{gap / self.deployment.period:.2f} periods ({1e3 * gap:.0f} ms)"

        return _line(what, found, written)


def faults(events: Iterable[ChaosEvent]) -> str:
    """Return events as the options that ask for them."""
    said = []
    for event in events:
        lasting = "" if event.for_ is None else f":{event.for_:g}s"
        said.append(f"--{event.action} {event.target}@{event.at:g}{lasting}")
    return " ".join(said)


def _times(what: str, times: Iterable[float | None]) -> Line:
    found = [time for time in times if time is not None]
    return _line(what, found, lambda time: f"{1e3 * time:.0f} ms")


def _lengths(what: str, lengths: Iterable[float | None]) -> Line:
    found = [length for length in lengths if length is not None]
    return _line(what, found, distance)


def _line(what: str, found: Sequence[float], written: Callable[[float], str]) -> Line:
    if not found:
        return (what, "", "", "0")
    return (what, written(median(found)), written(max(found)), str(len(found)))
