"""A node of the user's own, from a file beside the deployment: no file of ours knows it."""

from pathlib import Path

import pytest

from runtime.config.deployment import load
from runtime.config.tree import ConfigError
from runtime.wire.security import access_list
from tests.runtime.conftest import ROOT, Robot, wait_for

MINE = '''
from typing import Annotated

from runtime.processes.node import Context, Node
from runtime.wire.messages import EndEffectorPose
from runtime.wire.topics import Topic

SEEN = Topic("camera/hand", EndEffectorPose, "camera", "seen_hand", urgent=False)


class Camera(Node):
    """Publishes where it sees the hand, and counts how often."""

    topics = (SEEN,)

    def __init__(self, *, rate: Annotated[float, "Hz"] = 20.0) -> None:
        if rate <= 0:
            raise ValueError(f"rate: {rate:g} must be positive")
        self._rate = rate

    def run(self, context: Context) -> None:
        out = context.bus.publisher("camera/hand")
        while not context.ending.wait(1 / self._rate):
            out.send(EndEffectorPose(context.t, (0.1, 0.2, 0.3), (0.0, 0.0, 0.0, 1.0)))
            self.state = f"has seen {context.robot.n} joints"


class Broken(Node):
    def run(self, context: Context) -> None:
        raise OSError("there is no camera")
'''
NODES = "nodes:\n  - {role: camera, class: own_camera:Camera, rate: 50 Hz}\n"
ARPH = (ROOT / "deploy" / "arph.yaml").read_text()


def deployment(folder: Path, nodes: str = NODES) -> str:
    (folder / "own_camera.py").write_text(MINE)
    file = folder / "mine.yaml"
    file.write_text(ARPH + "\n" + nodes)
    return str(file)


def launch(robot: Robot, *options: str, nodes: str = NODES) -> None:
    file = deployment(robot.folder, nodes)
    robot.start("launch", file, "--robot", robot.name, *options)


def test_a_node_publishes_is_shown_and_ends_with_the_run(robot: Robot) -> None:
    file = deployment(robot.folder)
    _, said = robot.run_in_time(2, file=file)
    assert "goal reached" in said, said
    (end,) = robot.log("camera", "end")
    assert end["code"] == 0
    over = robot.log("plant", "tick")[-1]["wall"]
    # the launcher asks who has not heard of the end, as a process may not have that stood still
    assert end["reason"] == "the run is over" or end["wall"] > over
    summary = {one["role"]: one for one in robot.summary["processes"]}
    assert len(summary["camera"]["pids"]) == 1


def test_a_node_is_killed_hung_and_revived_as_every_process_and_disturbs_no_run(
    robot: Robot,
) -> None:
    options = ["--kill", "camera@8", "--revive", "camera@11", "--hang", "camera@18:2s"]
    launch(robot, "--speed", "2", *options)
    wait_for(lambda: [*robot.folder.glob("runs/*")], "the run to begin")
    wait_for(lambda: len(robot.log("camera", "start")) == 2, "the node to be revived", 40.0)
    wait_for(lambda: (robot.run_folder / "summary.json").exists(), "the end of the run", 60.0)
    assert robot.summary["code"] == 0
    assert [one["restarts"] for one in robot.summary["processes"] if one["role"] == "camera"] == [1]


def test_a_message_of_a_node_reaches_a_tool(robot: Robot) -> None:
    launch(robot, "--duration", "10min")
    wait_for(lambda: "has seen 6 joints" in robot.tool("status").stdout, "the node to be shown")
    robot.working("echo", "camera/hand", "-n", "1", says='"camera/hand"')
    robot.working("kill", "camera")
    robot.working("revive", "camera")

    def is_over() -> bool:
        robot.tool("stop", "camera")
        return bool(robot.log("camera", "end"))

    wait_for(is_over, "the node to stop")
    assert robot.log("camera", "end")[-1]["reason"] == "asked to stop"


def test_a_node_that_fails_at_its_start_ends_no_run(robot: Robot) -> None:
    file = deployment(robot.folder, "nodes:\n  - {role: camera, class: own_camera:Broken}\n")
    code, said = robot.run_in_time(2, file=file)
    assert code == 0, said
    assert "there is no camera" in said


@pytest.mark.parametrize(
    ("entry", "says"),
    [
        ("role: camera, class: own_camera:Camera, rate: -1", "rate: -1 must be positive"),
        (
            "role: camera, class: own_camera:Camera, rat: 1",
            "unknown key 'rat'; did you mean 'rate'?",
        ),
        (
            "role: camera, class: own_camera:Camra",
            "own_camera has no Node class 'Camra'; did you mean",
        ),
        ("role: camera, class: own_camera:Camera, host: arm", "there is no host 'arm'"),
        ("role: plant, class: own_camera:Camera", "'plant' is a reserved name"),
        ("role: joint/9, class: own_camera:Camera", "'joint/9' is a reserved name"),
        ("role: operator, class: own_camera:Camera", "'operator' is a reserved name"),
        (
            "role: eye, class: own_camera:Camera}\n  - {role: e, class: own_camera:Camera",
            "has that key already",
        ),
        (
            "role: eye, class: own_camera:Camera}\n  - {role: eye, class: own_camera:Camera",
            "duplicate node eye",
        ),
        (
            "role: e/1, class: own_camera:Camera}\n  - {role: e-1, class: own_camera:Camera",
            "duplicate node e-1",
        ),
    ],
)
def test_a_mistake_in_a_node_is_told_with_its_place(tmp_path: Path, entry: str, says: str) -> None:
    file = deployment(tmp_path, f"nodes:\n  - {{{entry}}}\n")
    with pytest.raises(ConfigError) as refused:
        load(file)
    assert says in str(refused.value)
    assert str(refused.value).startswith(f"{file}:")


def test_nodes_have_the_slots_after_the_agents_and_survive_dump_and_load(tmp_path: Path) -> None:
    loaded = load(deployment(tmp_path))
    assert loaded.roles[-2:] == ("platform", "camera")
    (tmp_path / "again.yaml").write_text(loaded.dump())
    again = load(tmp_path / "again.yaml", only_role="plant")
    assert not again.nodes[0].class_.is_loaded
    assert again.contract.keys_of("camera") == ("diag/camera", "camera/hand")


def test_a_node_may_publish_on_its_own_topics_only(tmp_path: Path) -> None:
    loaded = load(deployment(tmp_path))
    rules = access_list("r", loaded.roles, loaded.contract)["rules"]
    allowed = [rule["key_exprs"] for rule in rules if rule["messages"] == ["put"]]
    assert ["r/diag/camera", "r/camera/hand"] in allowed


def test_with_certificates_a_node_is_heard(robot: Robot) -> None:
    file = Path(deployment(robot.folder))
    file.write_text(file.read_text() + "security: {keys: keys}\n")
    made = robot.msma("keys", "keys", str(file))
    assert made.returncode == 0, made.stderr
    assert (robot.folder / "keys" / "camera.pem").exists()
    robot.start("launch", str(file), "--robot", robot.name, "--duration", "10min")
    of = ("--robot", robot.name, "--file", str(file))
    wait_for(lambda: "has seen 6" in robot.msma("status", *of).stdout, "the node to be shown")
    robot.working("echo", "camera/hand", "-n", "1", *of, says='"camera/hand"')
