"""An agent that takes long to decide, beside others that do not."""

from runtime.wire.bus import Bus
from tests.runtime.conftest import ROOT, RUN_DEADLINE, Robot, wait_for

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
    robot.start("launch", str(file), "--robot", robot.name, "--duration", "10min")
    robot.until(1.0)
    seen: list[tuple[str, bool]] = []
    with Bus(robot.name, "a test", robot.mesh.visitor(), 1) as bus:
        bus.watch_alive(lambda key, there: seen.append((key, there)))
        wait_for(lambda: len(seen) >= 9, "all processes")

        def are_undisturbed() -> bool:
            """Tell whether for 5 s all keep their links, and all other joints their commands.

            On a busy machine any process may stand still for a while, but not over and over.
            """
            seen.clear()
            t = robot.t
            robot.until(t + 5.0)
            ages = [tick["age"] for tick in robot.log("plant", "tick") if t < tick["t"] <= t + 5.0]
            stood = [age for tick in ages for age in tick[:5] if age is None]
            return not stood and all(there for _, there in seen)

        wait_for(are_undisturbed, "the others to be undisturbed", RUN_DEADLINE)
