"""Tables and notes of the comparison with other systems."""

import math
from collections.abc import Mapping, Sequence
from statistics import median

from bench.bench import Table
from bench.echo.runner import Measurement
from bench.echo.workload import AGENTS, ROLES
from bench.interleaving import ratio
from bench.loop_tables import OURS, PLAIN
from bench.others.arrivals import Gap
from bench.others.kills import KillImpact

Runs = Mapping[int, Mapping[str, Sequence[Measurement]]]


def _ms(seconds: float) -> str:
    if seconds == math.inf:
        return "none"
    return f"{1e3 * seconds:.2f}" if seconds < 0.1 else f"{1e3 * seconds:.0f}"


def _beside(which: str, runs: Sequence[Measurement], others: Sequence[Measurement]) -> str:
    both = list(zip(runs, others, strict=False))  # a system that was left out has fewer rounds
    if not all(run.time(which) < math.inf for pair in both for run in pair) or not both:
        return ""
    return ratio([run.time(which) for run, _ in both], [run.time(which) for _, run in both]).text()


def latency_table(found: Runs) -> Table:
    """Return the latency of each system, and its share of answers in time."""
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
    head = ("rate", "system", "runs", "p50 [ms]", "p99", "max", "ticks that all answered in time",
            "p50 / plain Zenoh", "p99 / plain Zenoh")  # fmt: skip
    return Table("latency from state to command, at the plant", head, tuple(rows))


def costs_table(found: Runs) -> Table:
    """Return the cost of the plant, an agent, and the servers of the system."""
    rows = []
    for rate, sides in found.items():
        for side, runs in sides.items():
            rows.append((f"{rate} Hz", side, *_cost(runs)))
    head = ("rate", "system", "processes", "plant: cpu", "an agent", "servers", "all: cores",
            "an agent: PSS [MB]", "all: PSS [MB]")  # fmt: skip
    return Table("cost of the processes", head, tuple(rows))


def _cost(runs: Sequence[Measurement]) -> list[str]:
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
    """Return the time until all agents have answered once, over all runs."""
    every: dict[str, list[float]] = {}
    for sides in found.values():
        for side, runs in sides.items():
            every.setdefault(side, []).extend(run.ready for run in runs)
    rows = [
        (side, str(len(times)), f"{median(times):.2f}", f"{min(times):.2f}", f"{max(times):.2f}")
        for side, times in every.items()
    ]
    head = ("system", "starts", "median [s]", "minimum", "maximum")
    return Table("time from the start until every agent has answered once", head, tuple(rows))


def kills_table(kills: Mapping[str, Sequence[Sequence[KillImpact]]]) -> Table:
    """Return the gaps in commands after a SIGKILL."""
    rows = [
        (
            side,
            killed[0].what,
            gaps([each.gap for each in killed]),
            gaps([each.others for each in killed]),
            f"{min(each.back for each in killed)} of {len(AGENTS)}",
        )
        for side, rounds in kills.items()
        for killed in zip(*rounds, strict=True)
    ]
    head = ("system", "SIGKILL of", "gap in its commands [s]", "in those of others [s]",
            "agents at the end")  # fmt: skip
    return Table("longest gap in commands after a SIGKILL, at 60 ms", head, tuple(rows))


def gaps(found: Sequence[Gap]) -> str:
    """Return gaps as text: `0.12 (0.11 to 0.13)`, or `over 6.0` if one did not end."""
    if not all(gap.ended for gap in found):
        ended = sum(gap.ended for gap in found)
        least = min(gap.seconds for gap in found if not gap.ended)
        return f"over {least:.1f}: no end" + (f" in {len(found) - ended}" if ended else "")
    times = [gap.seconds for gap in found]
    return f"{median(times):.2f} ({min(times):.2f} to {max(times):.2f})"


def notes(versions: Mapping[str, str], failures: Sequence[str]) -> tuple[str, ...]:
    """Return the notes on the tables."""
    installed = ", ".join(f"{name} {number}" for name, number in versions.items())
    return (
        f"Compared: {installed or 'none'}, each in an environment of its own, from PyPI.",
        *failures,
        f"All systems but {OURS} only echo: a plant publishes three states a tick, a goal source "
        "its goal, and seven agents answer. Each is a process; messages are as large as MSMA's. "
        f"The same stopwatch measures all of them. {OURS} also decides: it moves the robot.",
        "Each run starts all processes anew; the systems take turns. Times are medians over the "
        "runs, max is the largest of all, ratios are of the same round (minimum to maximum).",
        "A system that answered less than half of the ticks in time is not measured again at that "
        "rate or above, so it has fewer runs, or no row.",
        f"Time until all have answered: the processes of {OURS} are started one by one here, as "
        "those of all systems; `msma launch` is faster.",
        "pyzmq: PUB and SUB over ipc. Cyclone DDS: best effort, keep last 1, loopback without "
        "multicast. dora-rs: one dataflow, queues of 1. SPADE: its own server, and one message for "
        "the three states, because its messages have one receiver.",
        "A gap is the longest time between two commands of one agent that arrive at the plant; for "
        f"{OURS}, that the plant executes. Undisturbed it is one period, 0.06 s. `no end`: not "
        "during the observation, which began with the kill.",
        "SPADE does not restart a dead agent or server: this bench did, at once. dora-rs: "
        "`restart_policy: on-failure` without a delay; the bench restarted the coordinator with "
        "its store, and the daemon with the dataflow, at once.",
    )
