"""What was measured beside others, as tables for people."""

import math
from collections.abc import Mapping, Sequence
from statistics import median

from bench.bench import Table
from bench.echo.runner import Measured
from bench.echo.workload import AGENTS, ROLES
from bench.interleaving import ratio
from bench.loop import OURS, PLAIN
from bench.others.arrivals import Gap
from bench.others.kills import KillImpact

Runs = Mapping[int, Mapping[str, Sequence[Measured]]]


def _ms(seconds: float) -> str:
    if seconds == math.inf:
        return "none"
    return f"{1e3 * seconds:.2f}" if seconds < 0.1 else f"{1e3 * seconds:.0f}"


def _beside(which: str, runs: Sequence[Measured], others: Sequence[Measured]) -> str:
    both = list(zip(runs, others, strict=False))  # who was given up has fewer rounds
    if not all(run.time(which) < math.inf for pair in both for run in pair) or not both:
        return ""
    return ratio([run.time(which) for run, _ in both], [run.time(which) for _, run in both]).text()


def answers_table(found: Runs) -> Table:
    """Return how fast each side answers, and how often in time."""
    rows = []
    for rate, sides in found.items():
        for side, runs in sides.items():
            due = sum(run.ticks["ticks"] + run.ticks["missed"] for run in runs)
            share = sum(run.ticks["in_time"] for run in runs) / due
            worst = max(run.time("worst") for run in runs)
            beside = [
                "" if side == PLAIN else _beside(which, runs, sides.get(PLAIN, ()))
                for which in ("p50", "p99")
            ]
            rows.append((
                f"{rate} Hz", side, str(len(runs)),
                *(_ms(median(run.time(which) for run in runs)) for which in ("p50", "p99")),
                _ms(worst), f"{100 * share:.2f} %", *beside,
            ))  # fmt: skip
    head = ("rate", "system", "runs", "p50 [ms]", "p99", "max", "ticks all answered in time",
            "p50 beside plain Zenoh", "p99 beside plain Zenoh")  # fmt: skip
    return Table("from state to command, at the plant", head, tuple(rows))


def costs_table(found: Runs) -> Table:
    """Return what the processes cost: the plant, an agent, and what is not the user's own."""
    rows = []
    for rate, sides in found.items():
        for side, runs in sides.items():
            rows.append((f"{rate} Hz", side, *_cost(runs)))
    head = ("rate", "system", "processes", "plant: cpu", "an agent", "servers", "all: cores",
            "an agent: PSS [MB]", "all: PSS [MB]")  # fmt: skip
    return Table("what the processes cost", head, tuple(rows))


def _cost(runs: Sequence[Measured]) -> list[str]:
    def cpu(names: Sequence[str]) -> str:
        used = [sum(run.usage[name].cpu for name in names) / len(names) for run in runs]
        return f"{100 * median(used):.1f} %"

    servers = [
        [usage.cpu for name, usage in run.usage.items() if name not in ROLES] for run in runs
    ]
    every = [sum(usage.pss for usage in run.usage.values()) for run in runs]
    one = [run.usage[role].pss for run in runs for role in AGENTS]
    return [
        f"{median(len(run.usage) for run in runs):g}",
        cpu(ROLES[:1]),
        cpu(AGENTS),
        f"{100 * median(map(sum, servers)):.1f} %" if any(servers) else "none",
        f"{median(run.cores for run in runs):.2f}",
        f"{median(one) / 1e6:.0f}",
        f"{median(every) / 1e6:.0f}",
    ]


def ready_table(found: Runs) -> Table:
    """Return how long all take to be there and to have answered once, over all runs."""
    every: dict[str, list[float]] = {}
    for sides in found.values():
        for side, runs in sides.items():
            every.setdefault(side, []).extend(run.ready for run in runs)
    rows = [
        (side, str(len(times)), f"{median(times):.2f}", f"{min(times):.2f}", f"{max(times):.2f}")
        for side, times in every.items()
    ]
    head = ("system", "starts", "median [s]", "least", "most")
    return Table("from the command until every agent has answered once", head, tuple(rows))


def blows_table(blows: Mapping[str, Sequence[Sequence[KillImpact]]]) -> Table:
    """Return how long commands stay away after a SIGKILL."""
    rows = [
        (
            side,
            struck[0].what,
            gaps([each.gap for each in struck]),
            gaps([each.others for each in struck]),
            f"{min(each.back for each in struck)} of {len(AGENTS)}",
        )
        for side, rounds in blows.items()
        for struck in zip(*rounds, strict=True)
    ]
    head = ("system", "SIGKILL of", "gap in its commands [s]", "in those of others [s]",
            "agents back")  # fmt: skip
    return Table("after a SIGKILL, at 60 ms: the longest gap in commands", head, tuple(rows))


def gaps(found: Sequence[Gap]) -> str:
    """Return some gaps in words: `0.12 (0.11 to 0.13)`, `over 6.0` if one did not end."""
    if not all(gap.ended for gap in found):
        ended = sum(gap.ended for gap in found)
        least = min(gap.seconds for gap in found if not gap.ended)
        return f"over {least:.1f}: no end" + (f" in {len(found) - ended}" if ended else "")
    times = [gap.seconds for gap in found]
    return f"{median(times):.2f} ({min(times):.2f} to {max(times):.2f})"


def notes(versions: Mapping[str, str], failures: Sequence[str]) -> tuple[str, ...]:
    """Return what one has to know to read the tables."""
    had = ", ".join(f"{name} {number}" for name, number in versions.items())
    return (
        f"Beside us: {had or 'none'}, each in an environment of its own, from PyPI.",
        *failures,
        f"All sides but {OURS} only echo: a plant tells three states a tick, a goal source its "
        "goal, and seven agents answer, each a process, with messages of our sizes. The same "
        f"stopwatch times all. {OURS} does this and thinks: it moves the robot.",
        "Every side is started anew for every run, in turn. Times are medians over the runs, "
        "max is the largest of all, ratios are of the same round (least to most).",
        "Who of the others answered less than half of the ticks in time was not asked at that rate "
        "again, nor at a higher one: fewer runs, or no line.",
        f"Until all have answered: the processes of {OURS} are started one by one here, each with "
        "a Python of its own, as those of all sides; `msma launch` is faster.",
        "pyzmq: PUB and SUB over ipc. Cyclone DDS: best effort, keep last 1, loopback without "
        "multicast. dora-rs: one dataflow, queues of 1. SPADE: its own server, one message for "
        "the three states, for its messages have one receiver.",
        "A gap is the longest while between two commands of one agent that arrive at the plant; "
        f"for {OURS}, that the plant obeys. Undisturbed it is one period, 0.06 s. `no end`: not "
        "before the watch ended, which began with the kill.",
        "SPADE has nothing that starts a dead agent or server again: this bench did, at once. "
        "dora-rs: `restart_policy: on-failure` without a delay; the coordinator with its store, "
        "the daemon and then the dataflow were started again by the bench, at once.",
    )
