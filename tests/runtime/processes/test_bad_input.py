"""What strangers send and what agents of strangers do never stops a loop (rule 9)."""

from pathlib import Path

import numpy as np
import pytest

from runtime.results.logs import read_log
from runtime.wire import topics
from runtime.wire.messages import Diag
from runtime.wire.refusals import Reason
from tests.runtime.conftest import ProcessGroup, wait_for

BAD_AGENTS = """
import numpy as np
from agents.agent import Agent

class Raises(Agent):
    def __init__(self, body): pass
    def decide(self, percepts): return 1 / 0

class SaysNaN(Raises):
    def decide(self, percepts): return np.array(np.nan)

class SaysTooMuch(Raises):
    def decide(self, percepts): return np.zeros(3)

class SaysWords(Raises):
    def decide(self, percepts): return "fast"

class Hurries(Raises):
    def decide(self, percepts): return np.array(99.0)
"""


def with_agent(processes: ProcessGroup, name: str, folder: Path) -> None:
    """Let joint/1 be an agent of the kind that nobody wants."""
    (folder / "bad_agents.py").write_text(BAD_AGENTS)
    processes.options += ["--set", f"modules={folder}"]
    processes.options += ["--set", f"agents.joint/1.class=bad_agents:{name}"]


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("Raises", "ZeroDivisionError"),
        ("SaysNaN", "a command that is not finite"),
        ("SaysTooMuch", "a command of shape (3,)"),
        ("SaysWords", "ValueError"),
    ],
)
def test_what_an_agent_gets_wrong_is_counted_logged_once_and_not_sent(
    processes: ProcessGroup, tmp_path: Path, name: str, reason: str
) -> None:
    with_agent(processes, name, tmp_path)
    processes.start("plant", "joint/1")
    bus = processes.visit()
    ring = bus.ring(topics.joint_command(1))
    diag = processes.until(
        bus, "joint/1", lambda d: d.refused.get("decide", {}).get(reason, 0) > 10, "counts"
    )
    assert list(diag.refused) == ["decide"]
    assert list(ring.waiting(1)) == []
    wait_for(lambda: read_log(processes.run, "joint/1", "refused"), "the log")
    (line,) = read_log(processes.run, "joint/1", "refused")
    assert reason in line["reason"]
    if name == "Raises":
        assert "return 1 / 0" in line["detail"]


def test_speeds_over_the_limit_are_cut_to_it_and_counted(
    processes: ProcessGroup, tmp_path: Path
) -> None:
    with_agent(processes, "Hurries", tmp_path)
    processes.options += ["--set", "period=10ms"]
    processes.start("plant", "joint/1")
    bus = processes.visit()

    def counted(diag: Diag) -> bool:
        table = diag.refused.get(topics.joint_command(1), {})
        return bool(table.get(Reason.OVER_LIMIT, 0) > 10)

    processes.until(bus, "plant", counted, "counts them")

    def fastest() -> float:
        ticks = read_log(processes.run, "plant", "tick")
        return max((abs(tick["qd"][0]) for tick in ticks), default=0.0)

    limit = np.deg2rad(50.0)
    wait_for(lambda: fastest() > 0.999 * limit, "the joint to be as fast as it may")
    assert fastest() == pytest.approx(limit)
