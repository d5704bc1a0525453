"""Range sensors and things in the way, through real processes."""

from tests.runtime.conftest import ROOT, Robot

FILE = (ROOT / "deploy" / "arph-obstacles.yaml").read_text()
NICHE = """
world:
  - {name: wall, box: [10 cm, 2 m, 1 m], position: [60 cm, 0 m, 50 cm], fixed: true}
  - {name: left, box: [2 m, 10 cm, 1 m], position: [-15 cm, 60 cm, 50 cm], fixed: true}
  - {name: right, box: [2 m, 10 cm, 1 m], position: [-15 cm, -60 cm, 50 cm], fixed: true}
"""


def test_the_platform_goes_round_what_stands_in_its_way(robot: Robot) -> None:
    code, said = robot.run_in_time(3, file="arph-obstacles.yaml")
    if robot.summary["evaluation"]["touched"] and not robot.is_in_time:
        code, said = robot.run(file="arph-obstacles.yaml")  # where the agents have time enough
    assert code == 0, said
    assert robot.summary["evaluation"]["touched"] == []
    aside = [abs(line["base"][1]) for line in robot.log("plant", "tick")]
    assert max(aside) > 0.2, "the box is in the way"


def test_before_a_wall_it_stops_and_the_summary_says_why(robot: Robot) -> None:
    # In a niche, so that it can only stand there, however late its commands come on a busy machine;
    # how it stops before a wall in the open is tested in lockstep (tests/agents/test_avoiding.py).
    begin, _, rest = FILE.partition("world:")
    goal = rest.partition("goal:")[2].replace("36 s", "20 s")
    file = robot.folder / "niche.yaml"
    file.write_text(f"{begin.replace('50 s', '26 s')}{NICHE}goal:{goal}")
    code, said = robot.run("--speed", "3", file=str(file))
    assert code == 3, said
    assert robot.summary["evaluation"]["touched"] == []
    headline = said.partition(f"{robot.name}: goal missed: ")[2].splitlines()[0]
    assert "; platform stands: something 0." in headline
    assert headline.endswith("and sees no way round")
    assert "platform stands: something" in robot.summary["headline"]
