"""An agent that takes long to decide, beside others that do not."""

from runtime.wire.bus import Bus
from runtime.wire.mesh import on_loopback, port_base
from tests.runtime.conftest import ROOT, Robot, wait_for

SLOW = """
import time
from agents.joint import HoldAgent


class Slow(HoldAgent):
    def decide(self, percepts):
        time.sleep(0.2)  # what it does, and not a wait for anything
        return super().decide(percepts)
"""
ROLE = "{role: joint/6, class: %s}"


def test_a_slow_agent_costs_no_links_and_disturbs_no_others(robot: Robot) -> None:
    (robot.folder / "slow.py").write_text(SLOW)
    usual = (ROOT / "deploy" / "arph.yaml").read_text()
    text = usual.replace(ROLE % "agents.joint:HoldAgent", ROLE % "slow:Slow")
    assert text != usual
    file = robot.folder / "slow.yaml"
    file.write_text(text + "plant: {hold: 2 s}\n")
    robot.start("launch", str(file), "--robot", robot.name, "--duration", "60s")
    robot.until(1.0)
    seen: list[tuple[str, bool]] = []
    place = on_loopback(port_base(robot.name), 16).visitor()
    with Bus(robot.name, "a test", place, 1) as bus:
        bus.watch_alive(lambda key, there: seen.append((key, there)))
        wait_for(lambda: len(seen) >= 9, "all processes")
        robot.until(6.0)
    gone = {key for key, there in seen if not there}
    # if the test itself stands still for a quarter of a second, it loses its links to all of them
    assert gone in (set(), {key for key, _ in seen})
    ticks = [tick for tick in robot.log("plant", "tick") if 1.0 < tick["t"] < 6.0]
    ages = [tick["age"] for tick in ticks]
    assert all(age is not None for tick in ages for age in tick[:5]), "no other joint stands still"
