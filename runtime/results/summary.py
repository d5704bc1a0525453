"""The end of a run: its summary, as text for people and `summary.json` for programs, and a plot."""

import json
import math
import shlex
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

from runtime.atomic import write_atomically
from runtime.config.deployment import Deployment, Tolerance
from runtime.processes.lifetime import FAILED, INTERRUPTED, OK
from runtime.results.evaluation import SETTLING, Evaluation, Lost, Tracking, evaluate
from runtime.results.logs import read_log
from runtime.results.outcome import RunEvent, RunOutcome
from runtime.results.run_log import RunLog, RunLogError, read_run_log
from runtime.watching.table import columns, distance, milliseconds, off
from runtime.wire.messages import Spread
from runtime.wire.topics import PLANT

MISSED = 3
"""Exit code of a run that ended on time without reaching the goal."""


@dataclass(frozen=True)
class ProcessSummary:
    """The processes of one role.

    Attributes:
        pids: All of them, oldest first.
        answer: Latency of its answers to the plant [s]; None if it does not answer.
        host: The host of the last of them; empty if it published no diagnostics.
        rate: Loop rate of the last at the end [Hz].
        refused: How many messages the last refused, by topic and reason.
    """

    role: str
    pids: tuple[int, ...]
    restarts: int
    answer: Spread | None
    host: str = ""
    rate: float = 0.0
    refused: Mapping[str, Mapping[str, int]] = field(default_factory=dict)


@dataclass(frozen=True)
class Summary:
    """How a run went.

    Attributes:
        code: The exit code of the launcher.
        tolerance: Largest errors at the end that count as reaching the goal.
        evaluation: How well it went; None if the plant logged no motion.
        events: Faults, failures and restarts, in the order of plant time.
        again: The command that repeats the run.
        page: The address of the page from which a person could drive it; empty without one.
        plant: The class of its plant.
    """

    robot: str
    code: int
    headline: str
    tolerance: Tolerance
    evaluation: Evaluation | None
    events: tuple[RunEvent, ...]
    processes: tuple[ProcessSummary, ...]
    run: Path
    again: str
    page: str = ""
    plant: str = ""

    def to_json(self) -> str:
        """Return the summary for programs, in SI units."""
        plain = asdict(self) | {"events": [one._asdict() for one in self.events]}
        plain["tolerance"], plain["orientation_tolerance"] = self.tolerance.limits(True)
        for process in plain["processes"]:
            process["answer"] = process["answer"] and process["answer"]._asdict()
        return json.dumps(plain, indent=2, default=str) + "\n"

    def text(self) -> str:
        """Return the summary for a terminal."""
        lines = [f"{self.robot}: {self.headline}", *columns(list(self._facts())), ""]
        table = [("role", "pid", "host", "restarts", "loop Hz", "answer ms", "refused")]
        lines += [f"  {line}" for line in columns(table + [_line(one) for one in self.processes])]
        lines += ["", f"  answer: median/99 %/worst. All in {self.run}", f"  again: {self.again}"]
        return "\n".join(lines)

    def _facts(self) -> Iterator[tuple[str, str]]:
        yield "  plant", self.plant
        if self.evaluation is not None:
            if hand := self.evaluation.tracking:
                worst = off(hand.worst, hand.worst_angle)
                yield "  hand", f"{worst} off at worst after {SETTLING:g} s"
                limits = off(*self.tolerance.limits(hand.worst_angle > 0))
                within = f"within {limits} for {100 * hand.within:.1f} %"
                good = "" if hand.since is None else f", for good since {hand.since:.2f} s"
                yield "", f"{within} of that time{good}"
            if self.evaluation.by_sensors:
                yield "  motion", "as the sensors measured it: this plant knows no truth"
            if base := self.evaluation.platform:
                backwards = "went backwards" if base.reversed else "never went backwards"
                yield "  platform", f"{backwards}: {base.least_speed:.3f} m/s at least"
                heading, to_hand, yaw = map(_degrees, (base.heading, base.to_hand, base.arm_yaw))
                yield "", f"heading {heading}; the hand {to_hand} off it, joint 1 at {yaw}"
            for one in self.evaluation.touched:
                often = "once" if one.times == 1 else f"{one.times} times"
                force = "" if one.force is None else f", with {one.force:.3g} N at most"
                what = f"the {one.part} touched the {one.object} {often}"
                yield "  contact", f"{what}, first at {one.first:.1f} s{force}"
            for joint in self.evaluation.joints:
                if "elbow" in joint.name:
                    end, least = map(_degrees, (abs(joint.final), joint.straightest))
                    yield f"  {joint.name}", f"{end} off straight at the end, {least} at least"
        for event in self.events:
            yield f"  {event.t:.2f} s", event.text


def _degrees(angle: float) -> str:
    return f"{math.degrees(angle):.1f} deg"


def save(file: Path, write: Callable[[Path], object]) -> str:
    """Let `write` write a file; return why it could not, or "". It is there whole or not at all."""
    try:
        write_atomically(file, write)
    except OSError as error:
        return f"  {file} cannot be written: {error.strerror or error}"
    return ""


def close(
    deployment: Deployment,
    run: Path,
    outcome: RunOutcome,
    again: Sequence[str] = (),
    plot: bool = True,
) -> tuple[Summary, str]:
    """Write `summary.json` and a plot of a run; return the summary and what to say of the files."""
    try:
        log = read_run_log(run)
    except RunLogError:
        log = None
    summary = summarise(deployment, run, outcome, log, again)
    text = summary.to_json()
    said = [save(run / "summary.json", lambda file: file.write_text(text, encoding="utf-8"))]
    if plot and log is not None:
        try:
            from runtime.results.plots import draw
        except ImportError:
            said.append("  no plot without matplotlib: pip install 'msma[plots]'")
        else:
            file = run / "path.png"
            problem = save(file, lambda file: draw(log, deployment, summary.events, file))
            said.append(problem or f"  plot: {file}")
    return summary, "\n".join(filter(None, said))


def summarise(
    deployment: Deployment,
    run: Path,
    outcome: RunOutcome,
    log: RunLog | None,
    again: Sequence[str] = (),
) -> Summary:
    """Summarise the run in the folder `run`; `again` are the options that repeat it."""
    evaluation = None if log is None else evaluate(log, deployment)
    code, headline = _outcome(deployment, outcome, log, evaluation)
    events = [*outcome.events, *_logged(deployment, run, log)]
    for agent in deployment.agents:
        troubles = read_log(run, agent.role, "trouble")
        said = [RunEvent(one["t"], f"{agent.role} {one['why'] or 'goes on'}") for one in troubles]
        if code == MISSED and troubles and troubles[-1]["why"]:
            headline = f"{headline}; {said[-1].text}"
        events += said
    return Summary(
        robot=deployment.robot,
        code=code,
        headline=headline,
        tolerance=deployment.tolerance,
        evaluation=evaluation,
        events=tuple(sorted(events, key=lambda event: event.t)),
        processes=tuple(_processes(deployment, run, outcome)),
        run=run,
        again=shlex.join(["msma", "launch", str(run / "deployment.yaml"), *again]),
        page=outcome.page,
        plant=str(deployment.plant.class_),
    )


def _outcome(
    deployment: Deployment, outcome: RunOutcome, log: RunLog | None, evaluation: Evaluation | None
) -> tuple[int, str]:
    """Return the exit code and the headline."""
    if outcome.host not in (None, deployment.plant.host):
        return _of_share(outcome.host, outcome)
    if log is None or evaluation is None:
        failed = INTERRUPTED if outcome.code == INTERRUPTED else FAILED
        return failed, f"the robot never moved: {outcome.reason}"
    if outcome.code == INTERRUPTED:
        return INTERRUPTED, f"interrupted at {evaluation.t:.2f} s"
    if deployment.duration is not None and evaluation.t < deployment.duration - 1e-9:
        when = f"at {evaluation.t:.2f} s of {deployment.duration:g} s"
        if outcome.view.t > deployment.duration - 1e-9:
            return FAILED, f"the plant went on, but its log ends {when}: is the disk full?"
        why = log.end.get("reason", "its process was killed")
        code = FAILED if log.end.get("code", FAILED) == FAILED else INTERRUPTED
        return code, f"the plant ended {when}: {why}"
    if evaluation.tracking is None:
        return OK, f"ran to {evaluation.t:.2f} s"
    code, headline = _reached(evaluation, evaluation.tracking, deployment.tolerance)
    if evaluation.tracking.unfinished and log.modes:
        last = log.modes[-1]
        return MISSED, f"{_mode(last)} since {last['t']:.2f} s, before the path's end; {headline}"
    return code, headline


def _of_share(host: str, outcome: RunOutcome) -> tuple[int, str]:
    """Return code and headline for a host without the plant, which cannot evaluate the run."""
    t = outcome.view.t
    if outcome.code == INTERRUPTED:
        return INTERRUPTED, f"the share of {host} was interrupted at {t:.2f} s"
    if t == 0:
        return FAILED, f"the share of {host} saw no plant move: was the plant's host started?"
    return OK, f"the share of {host} ran to {t:.2f} s; the plant's host evaluates the run"


def _reached(evaluation: Evaluation, tracking: Tracking, tolerance: Tolerance) -> tuple[int, str]:
    turns = tracking.worst_angle > 0
    hand = f"the hand is {off(tracking.final, tracking.final_angle)} off at {evaluation.t:.2f} s"
    lost = "" if evaluation.lost is None else f"{_where(evaluation.lost)}; "
    if tracking.nearest is None:
        within = f"{hand}, within {off(*tolerance.limits(turns))}"
        return (MISSED, f"goal missed: {lost}{within}") if lost else (OK, f"goal reached: {within}")
    if min(tracking.nearest, tracking.final) > tolerance.position:
        hand += f"; it is {distance(tracking.nearest)} out of reach from where the platform is"
    elif not turns:  # whether an orientation is in reach is not known
        hand += ", though the arm could reach it from where the platform is"
    return MISSED, f"goal missed: {lost}{hand}"


def _where(lost: Lost) -> str:
    """Return what was lost, and where it is."""
    what = f"the {lost.object or 'object in the gripper'} is lost since {lost.t:.2f} s"
    if lost.position is None:
        return what
    x, y, z = lost.position
    return f"{what}, and at x {x:.2f} m, y {y:.2f} m, its middle {z:.2f} m above the floor"


def _logged(deployment: Deployment, run: Path, log: RunLog | None) -> Iterator[RunEvent]:
    """Yield the robot's faults and the restarts of processes, from the logs."""
    if log is None:
        return
    if not log.is_whole:
        what = "the plant's log begins here: what came before went over `log_megabytes`"
        yield RunEvent(float(log.t[0]), f"{what}, and no figure counts it")
    for event in log.modes:
        yield RunEvent(event["t"], _mode(event))
    for event in log.events:
        if event["event"] == "fault":
            yield RunEvent(event["t"], f"fault {event['fault']}")
        elif event["event"] == "gripper":
            what = f"the {event['object']}" if event["object"] else "something"
            said = f"has taken {what}" if event["holds"] else f"does not hold {what} any more"
            yield RunEvent(event["t"], f"the gripper {said}")
    for role, count in Counter(member.role for member in deployment.processes).items():
        for again in read_log(run, role, "start")[count:]:
            text = f"{role} was restarted{_recovery(run, log, again)}"
            yield RunEvent(log.t_at(again["wall"]), text)


def _mode(event: Mapping[str, Any]) -> str:
    """Return what to say of a change of the gate."""
    if event["halted_by"] is not None:
        return f"halted by {event['halted_by']}"
    return "at rest" if event["mode"] == "rest" else f"in {event['mode']} mode"


def _recovery(run: Path, log: RunLog, started: Mapping[str, Any]) -> str:
    """Return how long a restarted process took to its first accepted command, as text."""
    began = started["wall"]
    for line in read_log(run, "launcher", "chaos"):  # it may have been asked for before
        if (line["action"], line["target"]) == ("revive", started["role"]):
            began = line["wall"] if line["wall"] <= started["wall"] else began
    for event in log.events:
        if event["event"] == "obeys" and event["by"] == started["by"]:
            return f", first command accepted after {event['wall'] - began:.2f} s"
    return ""


def _processes(deployment: Deployment, run: Path, outcome: RunOutcome) -> list[ProcessSummary]:
    diags = {row.role: row.diag for row in outcome.view.rows if row.diag is not None}
    answers = diags[PLANT].answers if PLANT in diags else {}
    processes = []
    members = [one for one in deployment.processes if outcome.host in (None, one.host)]
    for role, count in Counter(one.role for one in members).items():
        pids = tuple(line["pid"] for line in read_log(run, role, "start"))
        one = ProcessSummary(role, pids, max(len(pids) - count, 0), answers.get(role))
        if diag := diags.get(role):
            one = replace(one, host=diag.host, rate=diag.rate, refused=diag.refused)
        processes.append(one)
    return processes


def _line(process: ProcessSummary) -> tuple[str, ...]:
    counts = sum(map(Counter, process.refused.values()), Counter[str]())
    return (
        process.role,
        str(process.pids[-1]) if process.pids else "",
        process.host,
        str(process.restarts),
        f"{process.rate:.4g}",
        milliseconds(process.answer, worst=True) if process.answer else "",
        ", ".join(f"{count} {reason}" for reason, count in counts.items()) or "0",
    )
