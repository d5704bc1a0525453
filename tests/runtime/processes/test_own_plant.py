"""A plant of the user's own, from a file beside the deployment: no file of ours knows it."""

from pathlib import Path

import pytest

from plant import urdf
from runtime.config.deployment import load
from runtime.config.tree import ConfigError
from runtime.wire.refusals import Reason
from tests.runtime.conftest import ROOT, Robot, wait_for

SERVOS = '''
from plant.kinematics import kinematics_of
from plant.plant import Commands, Plant, Readings, Setup


class Servos(Plant):
    """Ideal servos that record what they are given."""

    def __init__(self, setup: Setup, *, ratio: float = 1.0) -> None:
        super().__init__(setup)
        if ratio <= 0.0:
            raise ValueError(f"ratio: {ratio:g} must be positive")
        self.t, self.q, self.ratio = 0.0, setup.q, ratio
        self.speeds = (0.0,) * self.robot.n

    def open(self) -> None:
        self.record = open("record.txt", "w")

    def write(self, commands: Commands) -> None:
        self.speeds = tuple(self.ratio * speed for speed in commands.joints)
        print(*commands.joints, file=self.record)

    def step(self) -> None:
        self.t = round(self.t + self.period, 9)
        self.q = tuple(q + v * self.period for q, v in zip(self.q, self.speeds))

    def read(self) -> Readings:
        arm = kinematics_of(self.robot).forward_of_one(self.q, (0.0, 0.0, 0.0))
        return Readings(self.t, self.q, self.speeds, *arm.tip_of_one)

    def close(self) -> None:
        print("closed", file=self.record, flush=True)
'''
RACER = '''
from agents.agent import Agent, Body


class Racer(Agent):
    """Wants to be faster than any joint."""

    def __init__(self, body: Body) -> None:
        pass

    def decide(self, percepts):
        return 99.0
'''
BROKEN = """
from own_servos import Servos


class BrokenStep(Servos):
    def step(self) -> None:
        super().step()
        if self.t > 0.2:
            raise OSError("bus off")


class BrokenOpen(Servos):
    def open(self) -> None:
        raise OSError("bus off")
"""
PLANAR5 = (ROOT / "deploy" / "planar5.yaml").read_text()
PLANT = "plant: {class: own_servos:Servos, ratio: 0.9}\n"


def write_files(
    folder: Path, plant: str = PLANT, last_agent: str = "agents.joint:JointAgent"
) -> str:
    """Write the plant, an agent and a deployment beside each other."""
    (folder / "own_servos.py").write_text(SERVOS)
    (folder / "own_racer.py").write_text(RACER)
    file = folder / "own.yaml"
    old = "joint/5, class: agents.joint:JointAgent"
    file.write_text(PLANAR5.replace(old, f"joint/5, class: {last_agent}") + "\n" + plant)
    return str(file)


def test_a_plant_of_40_lines_is_moved_along_the_path(robot: Robot) -> None:
    assert len(SERVOS.strip().splitlines()) <= 40
    file = write_files(robot.folder)
    # at half speed, so that a busy machine has time for 50 decisions a second of each agent
    code, said = robot.run_in_time(0.5, "--duration", "6s", file=file)
    assert code == 0, said
    assert "as the sensors measured it" in said
    assert robot.summary["evaluation"]["by_sensors"]
    assert robot.log("plant", "no truth")
    record = (robot.folder / "record.txt").read_text().splitlines()
    assert len(record) == 301, "one write for each period of 20 ms, and closed once"
    assert record[-1] == "closed"


def test_any_plant_gets_lawful_commands_only_and_no_faults_that_it_cannot_have(
    robot: Robot,
) -> None:
    file = write_files(robot.folder, last_agent="own_racer:Racer")
    robot.start("launch", file, "--robot", robot.name, "--duration", "1 h")
    robot.until(0.5)

    def refused() -> str:  # a busy plant may answer too late
        said = robot.tool("fault", "joint/1:locked")
        return said.stderr if said.returncode == 2 else ""

    said = wait_for(refused, "it to be refused")
    assert "joint/1:locked: a Servos cannot be given faults" in said
    record = (robot.folder / "record.txt").read_text

    def fastest() -> float:
        lines = record().rpartition("\n")[0].splitlines()
        return max((float(line.split()[4]) for line in lines), default=0.0)

    limit = urdf.load("planar5").joints[4].max_speed
    assert wait_for(fastest, "a command") == limit
    wait_for(lambda: robot.tool("stop") and record().endswith("closed\n"), "the plant to be closed")
    over = [line for line in robot.log("plant", "refused") if line["reason"] == Reason.OVER_LIMIT]
    assert len(over) == 1, "said once"


def test_a_plant_that_fails_is_closed_and_its_process_ends_with_the_error(robot: Robot) -> None:
    file = write_files(robot.folder, "plant: {class: own_broken:BrokenStep}\n")
    (robot.folder / "own_broken.py").write_text(BROKEN)
    robot.start("launch", file, "--robot", robot.name)
    wait_for(lambda: robot.t >= 0.2 and robot.log("plant", "end"), "the plant to end")
    (end,) = robot.log("plant", "end")
    assert (end["code"], end["reason"]) == (1, "OSError: bus off")
    assert (robot.folder / "record.txt").read_text().endswith("closed\n")


def test_a_plant_that_cannot_be_opened_starts_no_run(robot: Robot) -> None:
    file = write_files(robot.folder, "plant: {class: own_broken:BrokenOpen}\n")
    (robot.folder / "own_broken.py").write_text(BROKEN)
    done = robot.msma("launch", file, "--robot", robot.name)
    assert done.returncode == 1
    assert "OSError: bus off" in done.stdout + done.stderr


@pytest.mark.parametrize(
    ("plant", "says"),
    [
        (
            "plant: {class: own_servos:Servo}\n",
            "own_servos has no Plant class 'Servo'; did you mean 'Servos'?",
        ),
        ("plant: {class: own_servos:Servos, ratio: 0}\n", "plant.ratio: 0 must be positive"),
        (
            "plant: {class: own_servos:Servos, ratoi: 1}\n",
            "unknown key 'ratoi'; did you mean 'ratio'?",
        ),
        ("plant: {class: plant.kinematik:Servos}\n", "did you mean 'plant.kinematic'?"),
    ],
)
def test_a_mistake_in_the_plant_is_told_with_its_line(
    tmp_path: Path, plant: str, says: str
) -> None:
    file = write_files(tmp_path, plant)
    with pytest.raises(ConfigError) as error:
        load(file)
    line = len(Path(file).read_text().splitlines())
    assert f"own.yaml:{line}:" in str(error.value)
    assert says in str(error.value)


def test_a_deployment_is_written_out_with_its_plant(tmp_path: Path) -> None:
    deployment = load(write_files(tmp_path))
    again = tmp_path / "again.yaml"
    again.write_text(deployment.dump())
    assert load(again) == deployment
    assert load(again).plant.parameters == {"ratio": 0.9}


def test_the_plant_s_class_is_imported_for_the_plant_only(tmp_path: Path) -> None:
    file = write_files(tmp_path, "plant: {class: not_there:Servos, ratio: 0.9}\n")
    deployment = load(file, only_role="joint/1")
    assert deployment.plant.parameters == {"ratio": "0.9"}
    with pytest.raises(ConfigError, match="there is no module 'not_there'"):
        load(file, only_role="plant")
