"""What a process says on the bus of where its files are is not believed."""

import random
import socket
from collections.abc import Callable, Iterator
from pathlib import Path
from zlib import crc32

import pytest

from runtime import VERSION
from runtime.wire import topics
from runtime.wire.bus import Bus
from runtime.wire.mesh import ALL_BASES, on_loopback, port_base
from runtime.wire.messages import Diag, Spread
from runtime.wire.packing import stamped
from tests.ports import reserve_any, reserve_free
from tests.runtime.conftest import ROOT, Robot, wait_for

EVIL = "open({marker!r}, 'w')\nfrom agents.joint import HoldAgent\nclass Evil(HoldAgent): pass\n"


@pytest.fixture
def planted(tmp_path: Path) -> Path:
    """Make a folder as a run has, whose deployment names a class that leaves a mark."""
    folder = tmp_path / "planted"
    folder.mkdir()
    (folder / "evil.py").write_text(EVIL.format(marker=str(folder / "imported")))
    return folder


@pytest.fixture
def fake_plant(robot: Robot, planted: Path) -> Iterator[Bus]:
    """Answer as the plant of the robot, and name the planted folder."""
    text = (ROOT / "deploy" / "arph.yaml").read_text()
    text = text.replace("robot: arph", f"robot: {robot.name}")
    text = text.replace("joint/2, class: agents.joint:JointAgent", "joint/2, class: evil:Evil")
    assert "evil:Evil" in text
    (planted / "deployment.yaml").write_text(text)
    none = Spread(0.0, 0.0, 0.0)
    diag = Diag(
        t=1.0,
        role="plant",
        host=socket.gethostname(),
        pid=1,
        state="runs",
        rate=16.7,
        work=none,
        answers={},
        refused={},
        perception="none",
        run=str(planted),
        deployment=str(planted / "deployment.yaml"),
        version=VERSION,
        clock=0,
    )
    seat = on_loopback(port_base(robot.name)).endpoints(0)
    with Bus(robot.name, "plant", seat, random.getrandbits(60)) as bus:
        bus.announce("plant")
        bus.answer(topics.diag("plant"), lambda _: stamped(diag, bus.incarnation, 1))
        yield bus


@pytest.mark.parametrize("verb", [("revive", "joint/2"), ("kill", "joint/2"), ("kill", "plant")])
def test_a_run_that_only_the_bus_names_is_refused(
    robot: Robot, fake_plant: Bus, planted: Path, verb: tuple[str, str]
) -> None:
    said = robot.tool(*verb)
    assert said.returncode == 1
    assert "--file RUN/deployment.yaml" in said.stderr
    assert f"this user has started no run of {robot.name} here" in said.stderr
    assert {file.name for file in planted.iterdir()} == {"evil.py", "deployment.yaml"}


def test_status_shows_such_a_robot_and_opens_none_of_its_files(
    robot: Robot, fake_plant: Bus, planted: Path
) -> None:
    said = robot.tool("status")
    assert said.stdout.startswith(f"{robot.name}: "), said.stderr
    assert "joint/2" not in said.stdout
    assert not (planted / "imported").exists()


def test_a_process_by_hand_does_not_log_where_only_the_bus_says(
    robot: Robot, fake_plant: Bus, planted: Path
) -> None:
    file = str(ROOT / "deploy" / "arph.yaml")
    robot.start("agent", file, "joint/1", "--robot", robot.name)
    wait_for(lambda: list(robot.folder.glob("runs/*/joint-1.jsonl")), "a log in an own folder")
    assert {file.name for file in planted.iterdir()} == {"evil.py", "deployment.yaml"}


def test_robots_whose_names_share_their_ports_run_at_once_and_are_found(
    make_robot: Callable[[], Robot],
) -> None:
    robots = make_robot(), make_robot()
    base, first = reserve_any()
    following = ALL_BASES[(ALL_BASES.index(base) + 1) % len(ALL_BASES)]
    while (second := reserve_free(following)) is None:
        first.close()
        base, first = reserve_any()
        following = ALL_BASES[(ALL_BASES.index(base) + 1) % len(ALL_BASES)]
    with first, second:
        for robot, name in zip(robots, names_at(base), strict=False):
            robot.name = name
            robot.launch("--duration", "10min")
        for robot in robots:
            robot.until(0.1)
            assert robot.working("status", says="joint/6").startswith(f"{robot.name}: ")

            def has_stopped(robot: Robot = robot) -> bool:
                robot.tool("stop")
                return not robot.processes()

            wait_for(has_stopped, "its end")


def names_at(base: int) -> Iterator[str]:
    """Yield names of robots that share their usual ports."""
    wanted = ALL_BASES.index(base)
    tried = random.getrandbits(32)
    while True:
        tried += 1
        name = f"test-{tried:x}"
        if crc32(name.encode()) % len(ALL_BASES) == wanted:
            yield name
