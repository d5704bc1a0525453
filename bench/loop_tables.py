"""Tables and notes of the loop bench, and the names of the systems in it."""

from collections.abc import Mapping, Sequence
from statistics import median

from bench.bench import Table
from bench.echo.runner import Measurement
from bench.echo.workload import ROLES
from bench.interleaving import ratio

OURS, PLAIN, DECIDING = "msma", "plain Zenoh", "plain Zenoh that reads and decides"
EVERY_STATE = "msma, deciding on every state"
"""MSMA without `Agent.rest`, to show what that saves."""
PAGE_OPEN = "msma, with its page open"
"""MSMA with the page by which a person drives, and a viewer who looks at it."""
BUSY = "msma, other programs on all cores"
"""MSMA beside a busy loop on each core, so that no core is ever idle."""

Runs = Mapping[str, Sequence[Measurement]]


def in_time(runs: Sequence[Measurement]) -> int:
    """Return the number of ticks that all agents answered in time."""
    return sum(int(run.ticks["in_time"]) for run in runs)


def due(runs: Sequence[Measurement]) -> int:
    """Return the number of ticks that were due."""
    return sum(int(run.ticks["ticks"] + run.ticks["missed"]) for run in runs)


def times_table(found: Mapping[int, Runs]) -> Table:
    """Return the latencies, and the share of ticks answered in time."""
    rows = []
    for rate, sides in found.items():
        for side, runs in sides.items():
            times = [
                f"{1e3 * median(run.time(which) for run in runs):.2f}"
                for which in ("p50", "p99", "p999", "worst")
            ]
            beside = [
                ratio([run.time(which) for run in runs], [run.time(which) for run in sides[PLAIN]])
                for which in ("p50", "p99")
            ]
            rows.append((f"{rate} Hz", side, *times, f"{100 * in_time(runs) / due(runs):.3f} %",
                         *(each.text() if side != PLAIN else "" for each in beside)))  # fmt: skip
    head = ("rate", "system", "p50 [ms]", "p99", "p99.9", "max", "all in time",
            "p50 / plain", "p99 / plain")  # fmt: skip
    return Table("latency from state to command, at the plant", head, tuple(rows))


def costs_table(found: Mapping[int, Runs]) -> Table:
    """Return the processor time and the memory of the processes."""
    rows = []
    for rate, sides in found.items():
        for side, runs in sides.items():
            cells = []
            for group in (("plant",), ("goal",), ROLES[2:]):
                used = [run.usage[role] for run in runs for role in group]
                cells.append(f"{100 * median(usage.cpu for usage in used):.1f} %")
            every = [usage for run in runs for usage in run.usage.values()]
            rows.append((
                f"{rate} Hz", side, *cells, f"{median(run.cores for run in runs):.2f}",
                f"{max(usage.pss for usage in every) / 1e6:.1f}",
                f"{max(usage.rss for usage in every) / 1e6:.1f}",
                f"{max(usage.threads for usage in every)}",
            ))  # fmt: skip
    head = ("rate", "system", "plant: cpu", "goal", "an agent", "all: cores",
            "largest PSS [MB]", "RSS [MB]", "threads")  # fmt: skip
    return Table("cost of the processes", head, tuple(rows))


NOTES = (
    "Each round starts all processes of each system anew. Times are medians over the rounds, "
    "shares are of all ticks, ratios are of two systems in the same round (minimum to maximum).",
    "Plain Zenoh has the same sessions, keys, message sizes and number of processes; its agents "
    "only return the number of the tick.",
    "MSMA's agents answer every state and decide at most 100 times a second. In between they "
    "repeat the last decision, because within a twelfth of its horizon their law gives the same "
    "result. They answer first and then decide, so that no answer waits for a decision. "
    f"'{EVERY_STATE}' has neither.",
    "Plain Zenoh that reads and decides does in each agent what our agent's law does for a "
    "decision, as often as MSMA, on recorded percepts, and in the plant a step of the simulation. "
    "All of its processes also pack and unpack the messages of the wire contract that this needs. "
    "So it shows the limit for this number of Python processes with these laws and messages. MSMA "
    "also arbitrates between sources, assembles percepts, and logs. Its processor time per tick "
    "beyond that of the plain echo is the cost of unpacking, deciding and packing beside other "
    "processes.",
    "All processes of all systems ask for real-time scheduling, as those of a launch do. Where it "
    "is not granted, programs on all cores delay a robot. Where it is granted, they help: a core "
    "that is never idle need not be woken, which takes long on a virtual machine.",
    "A tick is answered in time if the commands of all seven agents arrive within its period at "
    "the process that published it, by that process's clock. Ticks that it was too late to publish "
    "count as not answered.",
)
