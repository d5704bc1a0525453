"""How the cost of the loop grows with the number of joints: 4 to 64 agents of a planar arm."""

import tempfile
import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from statistics import median
from typing import NamedTuple

import numpy as np
import psutil

from bench.bench import Bench, BenchError, Check, Result, Table
from bench.launched import Launched, launched
from bench.ticks import quantile
from bench.usage import Meter, Usage
from runtime.config.deployment import load
from runtime.results.evaluation import errors
from runtime.results.logs import read_log
from runtime.results.run_log import read_run_log
from runtime.wire.topics import PLANT
from studies.study import Progress, Row

SIZES = (4, 8, 16, 32, 64)
PERIOD, SECONDS = 0.06, 5.0
"""Control period, and duration of each measurement [s]."""
FULL, STAR, HOSTS = "full mesh", "plant and goal only", "full mesh, three hosts"
HOSTS_UP_TO = 16
"""Joints of the longest arm on three hosts, which are namespaces that share these cores."""
BARRED = 32
NEAR = 0.01
"""Largest error of a run that counts as done [m]: a hundredth of the arm's length."""
_START_TIMEOUT = 25.0  # [s] until the plant executes the commands of all agents
_SETTLED = 2.0  # [s] without a new connection, after which no more is expected
_OTHERS = 2  # the plant and the goal source


class ArmMeasurement(NamedTuple):
    """Results for one arm.

    Attributes:
        joints: Number of joints.
        due: Number of answers due: ticks times agents.
        answered: Number of those that arrived within their period.
        p50: Median latency from a state to a command [s].
        p99: 99th percentile of it [s].
        cpu: Cores that all processes use together.
        agent: Share of a core of the median agent.
        pss: Memory of the largest process, and of all together [bytes].
        links: Number of connections between all processes.
        off: Error of the hand at the end [m].
        ready: Time from the command until the plant executes the commands of all agents [s].
    """

    joints: int
    due: int
    answered: int
    p50: float
    p99: float
    cpu: float
    agent: float
    pss: tuple[int, int]
    links: int
    off: float
    ready: float


class ScaleBench(Bench):
    """Latency, processor time, memory and connections of arms with more and more joints."""

    name = "scale"
    title = "From 4 to 64 agents of one arm"

    def __init__(self, sizes: Sequence[int] = SIZES, *, hosts: bool = True) -> None:
        """Measure arms with `sizes` joints; with `hosts`, also on three hosts."""
        self._sizes, self._hosts = sizes, hosts

    def measure(self, size: float, progress: Progress) -> Result:
        """Measure every arm with a full mesh, with a star, and on three hosts."""
        seconds = max(SECONDS * size, 1.0)
        sides = [(side, n) for n in self._sizes for side in (FULL, STAR)]
        if self._hosts:
            sides += [(HOSTS, n) for n in self._sizes if n <= HOSTS_UP_TO]
        progress.begin(len(sides))
        found: dict[str, list[ArmMeasurement]] = {}
        failed = []
        for side, joints in sides:
            progress.step(f"{joints} joints, {side}")
            try:
                found.setdefault(side, []).append(_grow(joints, side, seconds))
            except BenchError as error:
                failed.append(f"{joints} joints, {side}: {error}")
        return Result(
            checks=tuple(
                Check(f"{one.joints} joints, {side}: error of the hand", f"{1e3 * one.off:.2f} mm",
                      one.off < NEAR)
                for side, runs in found.items() for one in runs
            ),
            bars=_bars(found),
            tables=(_table(found), _growth(found)),
            notes=(*NOTES, *(f"not measured: {one}" for one in failed)),
            data={side: [one._asdict() for one in runs] for side, runs in found.items()},
        )  # fmt: skip

    def draw(self, result: Result, folder: Path) -> tuple[Path, ...]:
        """Draw processor use and latency over the number of joints."""
        from bench.drawing import growth

        return (growth(result.data, folder / "scale.png"),)


def _grow(joints: int, side: str, seconds: float) -> ArmMeasurement:
    """Launch an arm, and measure it once the plant executes the commands of all agents."""
    with tempfile.TemporaryDirectory(prefix="msma-bench-") as folder:
        file = write_arm(Path(folder), joints, spread=side == HOSTS)
        options = [str(file), "--robot", f"bench-scale-{joints}"]
        options += ["--rehearse"] if side == HOSTS else []
        with launched(options, star=side == STAR) as run:
            try:
                run.until(PLANT, "obeys", joints, _START_TIMEOUT)
            except BenchError:
                count = len({line["role"] for line in read_log(run.run, PLANT, "obeys")})
                raise BenchError(
                    f"after {_START_TIMEOUT:g} s only {count} of {joints} agents were active"
                ) from None
            ready = max(line["wall"] for line in read_log(run.run, PLANT, "obeys")) - run.commanded
            _settle(run)
            meter = _meter(run)
            begun = time.time()
            time.sleep(seconds)
            ended = time.time()
            usage = meter.usage() if meter else {}
            links = _links(run, meter)
            time.sleep(0.6)  # the plant writes its log twice a second
            record = read_run_log(run.run)
            deployment = load(run.run / "deployment.yaml")
    first, last = record.t_at(begun), record.t_at(ended)
    commands = record.arrivals(PERIOD)
    answered = sum(int(((times >= first) & (times < last)).sum()) for times in commands)
    inside = (record.t >= first) & (record.t < last)
    took = np.sort(PERIOD - record.age[inside].ravel())  # the period less the age of the command
    took = took[~np.isnan(took)]
    assert deployment.goal is not None
    return ArmMeasurement(
        joints,
        int(inside.sum()) * joints,
        min(answered, int(inside.sum()) * joints),
        quantile(took.tolist(), 0.5),
        quantile(took.tolist(), 0.99),
        sum(one.cpu for one in usage.values()),
        median([one.cpu for role, one in usage.items() if "/" in role] or [0.0]),
        _memory(usage),
        links,
        float(errors(record, deployment.goal.build())[-1, 0]),
        ready,
    )


def write_arm(folder: Path, joints: int, *, spread: bool = False) -> Path:
    """Write a planar arm of 1 m and its deployment with a goal on a circle; return that file."""
    length = 1.0 / joints
    parts = ["<robot name='long'><link name='link_0'/>"]
    for i in range(1, joints + 1):
        shift = 0.0 if i == 1 else length
        parts.append(
            f"<link name='link_{i}'/><joint name='joint_{i}' type='continuous'>"
            f"<parent link='link_{i - 1}'/><child link='link_{i}'/><origin xyz='{shift!r} 0 0'/>"
            "<axis xyz='0 0 1'/><limit velocity='0.87' acceleration='4' effort='10'/></joint>"
        )
    parts.append(
        f"<link name='tip'/><joint name='tip_joint' type='fixed'><parent link='link_{joints}'/>"
        f"<child link='tip'/><origin xyz='{length!r} 0 0'/></joint></robot>"
    )
    (folder / "long.urdf").write_text("\n".join(parts), encoding="utf-8")
    turn = 120.0 / joints  # the arm starts as a third of a circle
    angles = np.radians(np.arange(1, joints + 1) * turn - 60.0)
    x, y = length * np.cos(angles).sum(), length * np.sin(angles).sum()
    hosts = ("robot", "arm", "base") if spread else ()
    homes = [f", host: {('arm', 'base')[i % 2]}" if spread else "" for i in range(joints)]
    lines = [
        "robot: long",
        f"description: {folder / 'long.urdf'}",
        f"period: {PERIOD} s",
        "patience: 60 s",
        *([f"hosts: {{{', '.join(f'{h}: 127.0.0.{i + 1}' for i, h in enumerate(hosts))}}}"]
          if spread else []),
        "plant: {hold: 480 ms}",
        f"start: {{joints: [{turn - 60.0} deg{f', {turn} deg' * (joints - 1)}]}}",
        "goal:",
        "  class: agents.paths:Circle",
        f"  centre: [{x - 0.08:.6f} m, {y:.6f} m, 0 m]",
        f"  start: [{x:.6f} m, {y:.6f} m, 0 m]",
        "  rate: 18 deg/s",
        "  turns: 20",
        "agents:",
        *(f"  - {{role: joint/{i + 1}, class: agents.joint:JointAgent{homes[i]}}}"
          for i in range(joints)),
    ]  # fmt: skip
    file = folder / "long.yaml"
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return file


def _meter(run: Launched) -> Meter | None:
    """Return a meter of all processes of a run; None if they are in other pid namespaces."""
    pids = {}
    for log in sorted(run.run.glob("*.jsonl")):
        starts = [line for line in read_log(run.run, log.stem, "start") if "role" in line]
        if starts and starts[-1]["role"] != "launcher":
            pids[starts[-1]["role"]] = int(starts[-1]["pid"])
    visible = all(_is_of(pid, run.run) for pid in pids.values())
    return Meter(pids) if visible else None


def _is_of(pid: int, run: Path) -> bool:
    with suppress(OSError):
        return str(run).encode() in Path(f"/proc/{pid}/cmdline").read_bytes()
    return False


def _settle(run: Launched) -> None:
    """Wait until a run's processes have made no connection for a while."""
    until = time.monotonic() + _START_TIMEOUT
    links, since = -1, time.monotonic()
    while (now := time.monotonic()) < min(until, since + _SETTLED):
        count = _links(run, _meter(run))
        if count != links:
            links, since = count, now
        time.sleep(0.1)


def _links(run: Launched, meter: Meter | None) -> int:
    """Return the number of connections between processes of a run; 0 if they are not visible.

    Ports alone do not tell: another robot's are beside them, and any program's may be among them.
    """
    ends = {
        (end.laddr, end.raddr)
        for pid in ((run.process.pid, *meter.pids) if meter else ())
        for end in psutil.Process(pid).net_connections("tcp")
        if end.status == psutil.CONN_ESTABLISHED
    }
    return sum((there, here) in ends for here, there in ends) // 2


def _memory(usage: Mapping[str, Usage]) -> tuple[int, int]:
    sizes = [one.pss for one in usage.values()]
    return max(sizes, default=0), sum(sizes)


def _bars(found: Mapping[str, Sequence[ArmMeasurement]]) -> tuple[Row, ...]:
    rows = []
    for one in found.get(FULL, ()):
        if one.joints == BARRED:
            words = f"{one.answered} of {one.due}"
            rows.append(Row(f"{BARRED} joint agents at 60 ms: answers", "every tick of each",
                            words, one.answered == one.due))  # fmt: skip
    return tuple(rows)


def _table(found: Mapping[str, Sequence[ArmMeasurement]]) -> Table:
    rows = []
    for side, runs in found.items():
        for one in runs:
            known = one.cpu > 0
            rows.append((
                f"{one.joints}", side, f"{100 * one.answered / max(one.due, 1):.2f} %",
                f"{1e3 * one.p50:.1f}", f"{1e3 * one.p99:.1f}",
                f"{one.cpu:.2f}" if known else "", f"{100 * one.agent:.1f} %" if known else "",
                f"{one.pss[0] / 1e6:.0f}" if known else "",
                f"{one.pss[1] / 1e6:.0f}" if known else "",
                f"{one.links}" if known else "", f"{one.ready:.1f}",
            ))  # fmt: skip
    head = ("joints", "links", "answered", "p50 [ms]", "p99", "all: cores", "an agent: cpu",
            "largest PSS [MB]", "all", "connections", "all active after [s]")  # fmt: skip
    return Table("a planar arm of 1 m at 60 ms", head, tuple(rows))


def _growth(found: Mapping[str, Sequence[ArmMeasurement]]) -> Table:
    """Return the exponent with which each cost grows with the number of processes."""
    rows = []
    for side, runs in found.items():
        if len(runs) < 2 or not runs[0].cpu:
            continue
        more = np.log((runs[-1].joints + _OTHERS) / (runs[0].joints + _OTHERS))
        powers = [
            f"{np.log(max(b, 1e-9) / max(a, 1e-9)) / more:.2f}"
            for a, b in ((getattr(runs[0], name), getattr(runs[-1], name))
                         for name in ("p99", "cpu", "agent", "links"))
        ]  # fmt: skip
        rows.append((side, *powers))
    head = ("links", "p99", "all: cores", "an agent", "connections")
    return Table("growth with the number of processes: exponent", head, tuple(rows))


NOTES = (
    "The latency of an answer comes from the plant's log: the period less the age of the command "
    "at the start of the next step, so at most one period.",
    f"With '{STAR}' each agent connects only to the plant and the goal source. Agents do not "
    "exchange messages, so connections between them carry only keep-alives.",
    "Three hosts are three network namespaces that share this machine's cores.",
)
