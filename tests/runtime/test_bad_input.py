"""What strangers send and what agents of strangers do never stops a loop (rule 9)."""

import json
import random
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from runtime import keys
from runtime.bus import Bus
from runtime.messages import (
    GoalMessage,
    HandPose,
    JointCommand,
    JointStates,
    Message,
    PlatformCommand,
    PlatformPose,
    pack,
)
from runtime.refusals import Reason
from tests.runtime.conftest import Crew, wait_for

JOINTS = tuple(keys.joint_role(number) for number in range(1, 7))

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


def events(crew: Crew, role: str, event: str) -> list[dict[str, Any]]:
    path = crew.run / f"{keys.file_name(role)}.jsonl"
    lines = map(json.loads, path.read_text(encoding="utf-8").splitlines())
    return [line for line in lines if line["event"] == event]


def with_agent(crew: Crew, name: str, folder: Path) -> None:
    """Let joint/1 be an agent of the kind that nobody wants."""
    (folder / "bad_agents.py").write_text(BAD_AGENTS)
    crew.options += ["--set", f"modules={folder}"]
    crew.options += ["--set", f"agents.joint/1.class=bad_agents:{name}"]


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
    crew: Crew, tmp_path: Path, name: str, reason: str
) -> None:
    with_agent(crew, name, tmp_path)
    crew.start("plant", "joint/1")
    bus = crew.visit()
    ring = bus.ring(keys.joint_command(1))
    diag = crew.until(
        bus, "joint/1", lambda d: d.refused.get("decide", {}).get(reason, 0) > 10, "counts"
    )
    assert list(diag.refused) == ["decide"]
    assert list(ring.waiting(1)) == []
    wait_for(lambda: events(crew, "joint/1", "refused"), "the log")
    (line,) = events(crew, "joint/1", "refused")
    assert reason in line["reason"]
    if name == "Raises":
        assert "return 1 / 0" in line["detail"]


def test_speeds_over_the_limit_are_cut_to_it_and_counted(crew: Crew, tmp_path: Path) -> None:
    with_agent(crew, "Hurries", tmp_path)
    crew.options += ["--set", "period=10ms"]
    crew.start("plant", "joint/1")
    bus = crew.visit()
    diag = crew.until(bus, "plant", lambda d: d.t > 0.5, "runs for half a second")
    assert diag.refused[keys.joint_command(1)][Reason.OVER_LIMIT] > 10
    wait_for(lambda: len(events(crew, "plant", "tick")) > 40, "the log")
    speeds = [abs(tick["qd"][0]) for tick in events(crew, "plant", "tick")]
    assert max(speeds) == pytest.approx(np.deg2rad(50.0))


def samples(n: int) -> dict[str, Message]:
    """Return a sound message for each key."""
    return {
        keys.HAND: HandPose(1.0, (0.2, -0.2, 0.8), (0.0, 0.0, 0.0, 1.0), 77, n),
        keys.JOINTS: JointStates(1.0, (0.0,) * 6, (0.0,) * 6, 77, n),
        keys.PLATFORM: PlatformPose(1.0, 0.0, 0.0, 0.0, 77, n),
        keys.GOAL: GoalMessage(1.0, (0.3, 0.0, 0.5), (0.0, 0.0, 0.0), 0.0, 9.0, 77, n),
        keys.PLATFORM_COMMAND: PlatformCommand(1.0, 0.1, 0.1, 77, n),
        **{keys.joint_command(j): JointCommand(1.0, 0.1, 77, n) for j in range(1, 7)},
    }


def flood(bus: Bus, count: int, seconds: float, rng: random.Random) -> None:
    """Send that many random and mutated messages on every key, within so long [s]."""
    heard: dict[str, list[bytes]] = {}
    rings = {key: bus.ring(key) for key in samples(0)}
    began = time.monotonic()
    for n in range(count):
        for key, message in samples(n).items():
            heard.setdefault(key, [pack(message)])
            heard[key] += [arrival.data for arrival in rings[key].waiting(1)]
            data = bytearray(rng.choice(heard[key][-3:]))
            if rng.random() < 0.3:
                data = bytearray(rng.randbytes(rng.randrange(200)))
            for _ in range(rng.randrange(1, 4)):
                if data:
                    data[rng.randrange(len(data))] = rng.randrange(256)
            bus._session.put(key, bytes(data))
        time.sleep(max(0.0, began + seconds * n / count - time.monotonic()))


def test_in_a_flood_of_random_and_mutated_messages_the_run_goes_on(crew: Crew) -> None:
    crew.options += ["--duration", "10s"]
    crew.start("plant", "goal", *JOINTS, "platform")
    bus = crew.visit()
    crew.until(bus, "plant", lambda d: d.t > 1.0, "runs for a second")
    flood(bus, 2_000, seconds=5.0, rng=random.Random(5))
    assert crew.until(bus, "plant", lambda d: d.t > 1.0, "goes on").t < 10.0
    for role, key in (("plant", keys.joint_command(1)), ("joint/1", keys.JOINTS)):
        refused = crew.until(bus, role, lambda d: True, "answers").refused[key]
        assert sum(refused.values()) > 1_000
    for role in ("plant", "goal", *JOINTS, "platform"):
        assert crew.result(role, timeout=20.0)[0] == 0
    last = events(crew, "plant", "tick")[-1]
    goal = np.array([0.20, -0.18, 0.79]) + np.array([0.0, -0.07, 0.02]) * last["t"]
    assert np.linalg.norm(np.array(last["hand"]) - goal) < 0.003
