import re
import subprocess
import sys
from importlib import metadata
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from agents.markers import aim_at
from agents.number import ONE
from agents.paths import CsvPath, Line
from runtime.config.chaos import ChaosEvent
from runtime.config.deployment import Deployment, load
from runtime.config.overrides import Override
from runtime.config.tree import ConfigError
from runtime.results.reach import smallest_error
from tests.runtime.own_agents import Nudge

ROOT = Path(__file__).parents[3]


def shipped(file: Path) -> Any:
    """A deployment file; it is skipped where the package that has its robot is not installed."""
    description = yaml.safe_load(file.read_text())["description"]
    package = description.get("package") if isinstance(description, dict) else None
    missing = package is not None and not installed(package)
    marks = pytest.mark.skipif(missing, reason=f"{package} is not installed: msma[robots]")
    return pytest.param(file, marks=marks, id=file.stem)


def installed(package: str) -> bool:
    try:
        return metadata.distribution(package) is not None
    except metadata.PackageNotFoundError:
        return False


FILES = sorted((ROOT / "deploy").glob("*.yaml"))
SHIPPED = [shipped(file) for file in FILES]
EXAMPLES = yaml.safe_load((Path(__file__).parent / "bad_files.yaml").read_text())
GOOD: str = EXAMPLES["good"]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", [*sys.path])
    return tmp_path


def write(text: str, name: str = "x.yaml") -> str:
    Path(name).write_text(text, encoding="utf-8")
    return name


def read(text: str, **overrides: str) -> Deployment:
    given = [Override(f"--set {path}", path, value) for path, value in overrides.items()]
    return load(write(text), given)


def refused(text: str) -> str:
    with pytest.raises(ConfigError) as caught:
        read(text)
    return str(caught.value)


@pytest.mark.parametrize(("old", "new", "says"), EXAMPLES["misshapen"] + EXAMPLES["senseless"])
def test_an_error_names_its_location_and_what_is_valid(
    folder: Path, old: str | None, new: str, says: str
) -> None:
    said = refused(new if old is None else GOOD.replace(old, new, 1)).replace(str(folder), "FOLDER")
    if says.endswith("..."):
        said, says = said[: len(says) - 3], says[:-3]
    assert said == says


def test_a_platform_is_refused_where_the_robot_has_none() -> None:
    text = "robot: a\ndescription: planar5\nperiod: 1 ms\nagents: []\n"
    place = refused(text + "start: {platform: [0, 0, 0]}\n")
    assert place == "x.yaml:5:19: start.platform: planar5 has no platform; remove this key"
    still = "{role: platform, class: tests.runtime.own_agents:Still}"
    role = refused(text.replace("[]", f"[{still}]"))
    assert role.startswith("x.yaml:4:17: agents.platform.role: planar5 has no part 'platform';")


def test_more_agents_than_slots_are_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("runtime.config.deployment.FIRST_COPY", 4)
    assert refused(GOOD) == "x.yaml:14:3: agents: 5 processes with plant and goal; at most 4"


@pytest.mark.parametrize("file", SHIPPED)
def test_what_is_shipped_is_valid(file: Path) -> None:
    deployment = load(file)
    assert (deployment.duration is None) == deployment.has_page  # which goes on for a person


@pytest.mark.parametrize("file", SHIPPED)
def test_the_goal_of_what_is_shipped_is_within_reach_to_its_end(file: Path) -> None:
    deployment = load(file)
    assert deployment.goal is not None
    duration = deployment.duration or deployment.start.rest_after
    assert duration is not None
    path, robot = deployment.goal.build(), deployment.description.robot
    aim = aim_at(ONE, path.piece(duration), duration)
    base, q = np.array(deployment.start.base), np.array(deployment.start.joints)
    roams = robot.drive is not None
    assert deployment.tolerance.allows(*smallest_error(robot, aim, base, q, roams=roams))


def test_files_are_shipped() -> None:
    stems = {file.stem for file in FILES}
    assert stems >= {
        "arph",
        "arph-1khz",
        "arph-faults",
        "arph-pose",
        "planar5",
    }


def test_a_value_is_read_in_si() -> None:
    deployment = read(GOOD)
    assert (deployment.period, deployment.duration, deployment.robot) == (0.06, 24.0, "arph")
    assert deployment.start.joints == pytest.approx(np.deg2rad([0, 60, -115, 0, 0, 0]))
    assert deployment.start.base == (-0.15, 0.0, 0.0)
    assert deployment.agents[0].parameters["gain"] == 0.4
    assert [agent.joint for agent in deployment.agents] == [0, 1, None]


def test_a_default_follows_from_what_is_given(folder: Path) -> None:
    text = "robot: x\ndescription: arph\nperiod: 20 ms\nagents: []\n"
    deployment = read(text)
    assert deployment.plant.hold == 0.08
    assert deployment.start.joints == (0.0,) * 6
    assert deployment.start.platform == (0.0, 0.0, 0.0)
    assert deployment.runs == folder / "runs"
    assert deployment.modules == folder
    assert deployment.goal is None
    assert deployment.port != read(text, robot="y").port


def test_a_robot_without_a_platform_stands_at_the_origin() -> None:
    start = read("robot: x\ndescription: planar5\nperiod: 20 ms\nagents: []\n").start
    assert (start.platform, start.base) == (None, (0.0, 0.0, 0.0))


@pytest.mark.parametrize(
    ("more", "mode"),
    [
        ("", "automatic"),
        ("start: {mode: rest}", "rest"),
        ("nodes: [{role: hmi, class: tests.runtime.own_nodes:Page}]", "rest"),
        (
            "start: {mode: automatic, rest_after: 24 s}\n"
            "nodes: [{role: hmi, class: tests.runtime.own_nodes:Page}]",
            "automatic",
        ),
    ],
)
def test_a_robot_with_a_page_starts_at_rest_unless_it_says_otherwise(more: str, mode: str) -> None:
    text = f"robot: x\ndescription: arph\nperiod: 20 ms\nagents: []\n{more}\n"
    assert read(text).first_mode == mode
    assert read(read(text).dump()) == read(text)


@pytest.mark.parametrize("mode", ["shared", "manual", "fast"])
def test_no_robot_starts_in_a_mode_that_waits_for_a_press(mode: str) -> None:
    text = f"robot: x\ndescription: arph\nperiod: 20 ms\nagents: []\nstart: {{mode: {mode}}}\n"
    assert "start.mode" in refused(text)


def test_slots_are_plant_goal_and_the_agents_as_listed() -> None:
    deployment = read(GOOD, port="7000")
    assert deployment.roles == ("plant", "goal", "joint/1", "joint/2", "platform")
    assert deployment.slot("platform") == 4
    assert deployment.mesh.endpoints(2).listen == ("127.0.0.1", 7002)
    with pytest.raises(
        ConfigError, match="no process has the role 'joint/3'; did you mean 'joint/2'"
    ):
        deployment.slot("joint/3")


def test_without_a_goal_no_goal_process_has_a_slot() -> None:
    assert read(GOOD, goal="null").roles == ("plant", "joint/1", "joint/2", "platform")


def test_a_chaos_event_is_an_action_and_its_target() -> None:
    fault, kill = read(GOOD).chaos
    assert (fault.at, fault.action, fault.target) == (5.0, "fault", "joint/1:locked")
    assert kill == ChaosEvent(at=8.0, kill="joint/2")
    assert (kill.action, kill.target) == ("kill", "joint/2")


def test_an_agent_is_built_as_its_part_of_the_robot() -> None:
    deployment = read(GOOD)
    agent = deployment.build_agent("joint/1")
    assert isinstance(agent, Nudge)
    assert (agent.gain, agent.body.joint, agent.body.period) == (0.4, 0, 0.06)
    assert agent.body.robot is deployment.description.robot


def test_two_agents_draw_different_numbers_and_a_revived_one_the_same() -> None:
    deployment = read(GOOD.replace("own_agents:Still", "own_agents:Nudge"))

    def drawn(role: str) -> float:
        agent = deployment.build_agent(role)
        assert isinstance(agent, Nudge)
        return agent.body.rng.random()

    assert drawn("joint/1") == drawn("joint/1") != drawn("joint/2")


def test_the_path_is_built_from_its_parameters() -> None:
    goal = read(GOOD).goal
    assert goal is not None
    path = goal.build()
    assert isinstance(path, Line)
    assert path.piece(0.0).at(10.0) == pytest.approx([0.2, -0.88, 0.99])


def test_a_path_in_a_file_may_have_an_orientation() -> None:
    line = "class: agents.paths:Line"
    turning = "rpy: [0, 90 deg, 0]\n  angular_velocity: [0, 0, 10 deg/s]\n  free: roll"
    deployment = read(GOOD.replace(line, f"{line}\n  {turning}"))
    assert deployment.goal is not None
    piece = deployment.goal.build().piece(0.0)
    assert piece.orientation == pytest.approx([0.0, 0.5**0.5, 0.0, 0.5**0.5])
    assert piece.angular_velocity == pytest.approx([0.0, 0.0, np.pi / 18])
    assert piece.free == "roll"
    write(deployment.dump(), "dump.yaml")
    assert load("dump.yaml") == deployment


@pytest.mark.parametrize(
    ("more", "says"),
    [
        ("rpy: [0, 90, deg]", "x.yaml:11:16: goal.rpy.2: 'deg' is not an angle; write one such"),
        ("rpy: [0, 1 m, 0]", "x.yaml:11:12: goal.rpy.1: 1 m is a length; an angle is wanted"),
        ("orientation: [0, 0, 1]", "x.yaml:11:16: goal.orientation: expected 4 values, got 3"),
        ("orientation: [0, 0, 1, 1]", "x.yaml:11:16: goal.orientation: a unit quaternion x, y,"),
        ("free: roll", "x.yaml:11:9: goal.free: needs an orientation too, such as rpy: [0, 90"),
        ("free: yaw", "x.yaml:11:9: goal.free: 'yaw' is not a valid choice; valid are nothing, r"),
        ("rpi: [0, 0, 0]", "x.yaml:11:3: goal: unknown key 'rpi'; did you mean 'rpy'? valid are"),
    ],
)
def test_a_bad_orientation_is_refused_where_it_is_written(more: str, says: str) -> None:
    line = "class: agents.paths:Line"
    assert refused(GOOD.replace(line, f"{line}\n  {more}")).startswith(says)


@pytest.mark.parametrize(
    ("text", "position", "orientation"),
    [
        ("3 mm", 0.003, 1.0),
        ("{position: 5 mm}", 0.005, 1.0),
        ("{orientation: 2 deg}", 0.003, 2.0),
        ("{position: 1 cm, orientation: 0.5 deg}", 0.01, 0.5),
    ],
)
def test_a_tolerance_is_of_the_position_and_of_the_orientation(
    text: str, position: float, orientation: float
) -> None:
    tolerance = read(f"{GOOD}tolerance: {text}\n").tolerance
    assert tolerance.position == position
    assert np.degrees(tolerance.orientation) == pytest.approx(orientation)


def test_paths_in_a_file_are_relative_to_it(folder: Path) -> None:
    (folder / "deep").mkdir()
    (folder / "deep" / "way.csv").write_text("t,x,y,z\n0,0,0,0\n1,1,0,0\n")
    (folder / "deep" / "arm.urdf").write_bytes((ROOT / "plant/robots/arph.urdf").read_bytes())
    goal = "{class: agents.paths:CsvPath, file: way.csv}"
    text = f"robot: x\ndescription: arm.urdf\nperiod: 1 ms\nagents: []\ngoal: {goal}\n"
    deployment = load(write(text, "deep/x.yaml"))
    assert deployment.description.file == str(folder / "deep" / "arm.urdf")
    assert deployment.goal is not None
    assert isinstance(deployment.goal.build(), CsvPath)
    write(deployment.dump(), "dump.yaml")
    assert load("dump.yaml") == deployment


def test_a_file_that_a_path_needs_must_be_there(folder: Path) -> None:
    goal = "{class: agents.paths:CsvPath, file: way.csv}"
    text = f"robot: x\ndescription: arph\nperiod: 1 ms\nagents: []\ngoal: {goal}\n"
    assert refused(text) == f"x.yaml:5:43: goal.file: there is no file {folder / 'way.csv'}"
    (folder / "way.csv").write_text("t,x,y,z\n0,0,0,up\n")
    told = f"x.yaml:5:7: goal: {folder / 'way.csv'}:2: t, x, y and z must be four numbers"
    assert refused(text) == told


OWN = """
from agents.agent import Agent
class Mine(Agent):
    def __init__(self, body, *, pull: float): pass
    def decide(self, percepts): return None
"""


def test_classes_of_ones_own_lie_beside_the_file_or_in_modules(folder: Path) -> None:
    (folder / "beside_the_file.py").write_text(OWN)
    (folder / "elsewhere").mkdir()
    (folder / "elsewhere" / "in_modules.py").write_text(OWN)
    nudge = "tests.runtime.own_agents:Nudge, gain: 0.4"
    text = GOOD.replace(nudge, "beside_the_file:Mine, pull: 2")
    assert read(text).agents[0].parameters == {"pull": 2.0}
    text = text.replace("beside_the_file", "in_modules")
    assert read(text, modules="elsewhere").modules == folder / "elsewhere"


def test_an_error_in_a_module_is_reported_at_its_name(folder: Path) -> None:
    (folder / "broken_agents.py").write_text("1 / 0\n")
    (folder / "lacking_agents.py").write_text("import nothing_of_that_name\n")
    place = "x.yaml:14:28: agents.joint/1.class: module"
    told = refused(GOOD.replace("tests.runtime.own_agents", "broken_agents", 1))
    assert told == f"{place} broken_agents cannot be imported: ZeroDivisionError: division by zero"
    told = refused(GOOD.replace("tests.runtime.own_agents", "lacking_agents", 1))
    reason = "ModuleNotFoundError: No module named 'nothing_of_that_name'"
    assert told == f"{place} lacking_agents cannot be imported: {reason}"


def test_a_process_loads_the_class_of_its_own_role_only() -> None:
    text = GOOD.replace("tests.runtime.own_agents:Nudge, gain: 0.4", "nowhere:None_, gain: x")
    deployment = load(write(text), only_role="joint/2")
    assert deployment.agents[0].parameters == {"gain": "x"}
    deployment.build_agent("joint/2")
    with pytest.raises(ConfigError, match="loaded for another role"):
        deployment.build_agent("joint/1")
    with pytest.raises(ConfigError, match="no process has the role 'joint/5'"):
        load("x.yaml", only_role="joint/5")


def test_the_plants_process_imports_no_agent_nor_the_8_mb_of_random_numbers() -> None:
    not_needed = {
        "agents.joint",
        "agents.platform",
        "hashlib",
        "jsonschema",
        "numpy.random",
        "rich",
    }
    program = (
        "import sys; from runtime.config.deployment import load; "
        "import runtime.plant_node.plant_node; "
        f"load({str(ROOT / 'deploy/arph.yaml')!r}, only_role='plant').build_plant(); "
        f"print({not_needed} & set(sys.modules))"
    )
    result = subprocess.run(
        [sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True
    )
    assert result.stdout == "set()\n"


def lengths(low: float, high: float) -> st.SearchStrategy[float]:
    return st.floats(low, high, exclude_min=True)


def quoted(values: st.SearchStrategy[Any]) -> st.SearchStrategy[str]:
    return values.map(lambda value: yaml.safe_dump(value))


OVERRIDES = {
    "robot": quoted(st.from_regex("[A-Za-z0-9][A-Za-z0-9_-]{0,20}", fullmatch=True)),
    "period": quoted(lengths(0, 10)),
    "duration": st.one_of(quoted(st.floats(9, 1e6)), st.just("null")),
    "tolerance": st.one_of(quoted(lengths(0, 1e9)), st.just("{orientation: 2 deg}")),
    "seed": quoted(st.integers(0, 10**40)),
    "speed": quoted(lengths(0, 1e3)),
    "port": quoted(st.integers(1024, 65408)),
    "runs": quoted(st.text("aé: #-'\"/.", min_size=1)),
    "goal": st.just("null"),
    "start.joints": quoted(st.lists(st.floats(-1, 1), min_size=6, max_size=6)),
    "start.platform": quoted(st.lists(st.floats(-9, 9), min_size=3, max_size=3)),
    "plant.hold": quoted(st.floats(10, 1e9)),
    "agents.joint/1.gain": quoted(lengths(0, 9)),
    "agents.joint/1.bounds": quoted(st.lists(st.floats(-9, 9), min_size=2)),
    "agents.joint/1.note": st.one_of(quoted(st.text()), st.just("~")),
    "agents.joint/1.eager": st.sampled_from(["yes", "no", "true", "off"]),
    "hosts": st.sampled_from(["{a: 10.0.0.1}", "{b-2: {address: '::1', ssh: me@b}, a: a.local}"]),
    "chaos.+": st.sampled_from(["{at: 1, stop: goal}", "{at: 2 s, fault: 'joint/2:weak=20 %'}"]),
}


@pytest.fixture(scope="module")
def corner(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("corner")
    (place / "x.yaml").write_text(GOOD)
    return place


@given(values=st.fixed_dictionaries({}, optional=OVERRIDES))
def test_a_deployment_loads_again_from_what_it_dumps(corner: Path, values: dict[str, str]) -> None:
    if "goal" in values:
        values.pop("chaos.+", None)
    deployment = load(corner / "x.yaml", [Override("--set", *each) for each in values.items()])
    (corner / "dump.yaml").write_text(deployment.dump(), encoding="utf-8")
    again = load(corner / "dump.yaml")
    assert again == deployment
    assert again.dump() == deployment.dump()


SCRAPS = ["[", "{", "}", ":", "\n", "- ", "&a ", "*a", "!!x ", "'", "~", "-1 ms", "nan", "<<: "]
SCRAPS += ["\0", "x" * 300]


@settings(max_examples=200)
@given(data=st.data())
def test_a_garbled_file_is_read_or_refused_in_one_line(corner: Path, data: st.DataObject) -> None:
    text = GOOD
    for _ in range(data.draw(st.integers(1, 3))):
        start = data.draw(st.integers(0, len(text)))
        end = start + data.draw(st.sampled_from([0, 1, 3, 30]))
        text = text[:start] + data.draw(st.sampled_from(SCRAPS)) + text[end:]
    (corner / "garbled.yaml").write_text(text)
    try:
        load(corner / "garbled.yaml")
    except ConfigError as error:
        said = str(error)
    else:
        return
    assert re.match(rf"{corner}/garbled.yaml:\d+:\d+: .+$", said)


@pytest.mark.parametrize(
    ("names", "taken"),
    [
        ("[extra:Missing, plant.kinematic:KinematicPlant]", "plant.kinematic:KinematicPlant"),
        ("[plant.kinematic:KinematicPlant, extra:Missing]", "plant.kinematic:KinematicPlant"),
        ("[]", r"x.yaml:3:16: plant\.class: is empty; name a class, such as"),
        ("[extra:Missing]", r"module extra cannot be imported: .*needs another"),
        ("[wrong:Name, plant.kinematic:KinematicPlant]", r"x.yaml:3:17: .* no module 'wrong'"),
    ],
)
def test_of_a_list_of_classes_the_first_that_is_installed_counts(
    folder: Path, names: str, taken: str
) -> None:
    (folder / "extra.py").write_text("raise ImportError('it needs another package')\n")
    head, rest = GOOD.split("\n", 2)[:2], GOOD.split("\n", 2)[2]
    file = write("\n".join([*head, f"plant: {{class: {names}}}", rest]))
    if not taken.endswith("KinematicPlant"):
        with pytest.raises(ConfigError, match=taken):
            load(file)
    else:
        plant = load(file).plant.class_
        assert plant.name == taken
        assert load(write(load(file).dump(), "again.yaml")).plant.class_ == plant


def test_a_goal_may_have_a_standby() -> None:
    goal = "  class: agents.paths:Line\n"
    loaded = load(write(GOOD.replace(goal, f"{goal}  copies: 2\n")))
    assert [each.copy for each in loaded.processes if each.role == "goal"] == [False, True]
    with pytest.raises(ConfigError, match=r"goal\.host: 2 hosts but copies: 1"):
        load(write(GOOD.replace(goal, f"{goal}  host: [local, local]\n")))
