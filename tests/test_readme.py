"""The README stays true: every command and every piece of code in it is run."""

import json
import os
import re
import shlex
import shutil
import subprocess
import sys
from contextlib import ExitStack
from pathlib import Path

import pytest

from runtime.config.deployment import load
from runtime.results.logs import read_log
from runtime.results.summary import MISSED
from tests.runtime.conftest import DEADLINE, TOLERANCE, came_in_time, free_name, wait_for

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "README.md").read_text()
BIN = Path(sys.executable).parent


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", TEXT, flags=re.DOTALL | re.MULTILINE)


def commands(block: str) -> list[str]:
    lines = (line.partition(" #")[0].strip() for line in block.splitlines())
    return [line for line in lines if line and not line.startswith(". ")]


MAKE, BY_HAND, *LAUNCHES, RUNNING, SECURE, FETCH, STUDY = blocks("sh")


@pytest.fixture
def robot():
    """A robot's name that no other robot on this machine has, and whose ports are free."""
    with ExitStack() as stack:
        yield free_name(stack)


@pytest.fixture
def place(tmp_path, robot):
    """A folder with the project's deployment files, for a robot of that name."""
    shutil.copytree(ROOT / "deploy", tmp_path / "deploy", ignore=shutil.ignore_patterns("keys"))
    for file in (tmp_path / "deploy").glob("*.yaml"):
        file.write_text(re.sub(r"^robot: \S+", f"robot: {robot}", file.read_text(), flags=re.M))
    return tmp_path


def run(command: str, place: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        shlex.split(command), cwd=place, env=environment(), capture_output=True, text=True
    )


def launched(command: str, place: Path) -> subprocess.CompletedProcess[str]:
    """Launch, and again in real time where a busy machine was too slow for the speed."""
    wider = f" --set tolerance={TOLERANCE}m"  # there the hand may be off by more than is allowed
    done = run(command + wider, place)
    if done.returncode == MISSED and not came_in_time(next(place.glob("runs/*"))):
        shutil.rmtree(place / "runs")
        done = run(re.sub(" --speed [0-9.]+", "", command) + wider, place)
    return done


def environment() -> dict[str, str]:
    """Return that of a shell with the project's commands, also if make has begun these tests."""
    found = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
    return {**found, "PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}"}


@pytest.mark.parametrize("command", commands(MAKE))
def test_the_commands_with_make_are_there(command):
    assert makes(command)


def test_the_commands_without_make_are_those_of_the_makefile():
    made = [line for command in commands(MAKE) for line in makes(command)]
    install, *checks = commands(BY_HAND)[1:]
    assert commands(BY_HAND)[0] in made
    assert install in made
    assert checks == [line for line in made if line in checks]


def makes(command: str) -> list[str]:
    """Return the commands that a `make` command runs in a fresh clone."""
    if shutil.which("make") is None:
        pytest.skip("it takes make")
    done = run(f"{command} --dry-run --always-make VENV=.venv PYTHON=python3", ROOT)
    assert done.returncode == 0, done.stderr
    return [line.replace("--quiet ", "") for line in done.stdout.splitlines()]


@pytest.mark.parametrize(
    ("options", "file"),
    [
        ("", "arph"),
        ("RUN=task", "arph"),
        ("MAKE_TERMOUT=/dev/tty", "arph-web"),
        ("MAKE_TERMOUT=/dev/tty RUN=task", "arph"),
    ],
)
def test_make_opens_the_page_on_a_terminal_only(options, file):
    assert makes(f"make run {options}")[-1].endswith(f"msma-launch deploy/{file}.yaml")


@pytest.mark.parametrize(
    "command", [line for block in (*LAUNCHES, FETCH, STUDY) for line in commands(block)]
)
def test_a_command_that_needs_nothing_running_ends_well(command, place):
    done = launched(command, place) if command.startswith("msma-launch") else run(command, place)
    assert done.returncode == 0, done.stdout + done.stderr


def test_keys_are_made_and_the_robot_runs_by_them(place):
    for command in commands(SECURE):
        go = launched if command.startswith("msma-launch") else run
        done = go(command, place)
        assert done.returncode == 0, done.stdout + done.stderr
    assert "goal reached" in done.stdout


def test_a_running_robot_is_controlled_from_another_terminal(place, robot):
    launcher = subprocess.Popen(
        [BIN / "msma-launch", "deploy/arph.yaml", "--duration", "10min"],
        cwd=place,
        env=environment(),
        stdout=subprocess.DEVNULL,
    )
    try:
        status = f"msma status --robot {robot}"
        wait_for(lambda: "runs" in run(status, place).stdout, "the robot to start")
        for command in commands(RUNNING):

            def works(command: str = command) -> bool:
                done = run(f"{command} --robot {robot}", place)  # since others may run here
                allowed = (0, 1) if command == "msma doctor" else (0,)  # it may find something
                print(command, done.stdout, done.stderr)  # shown if it never works
                return done.returncode in allowed or launcher.poll() is not None

            # on a busy machine a process may answer too late, and a tool gives up soon
            wait_for(works, f"{command} to work")
        assert launcher.wait(DEADLINE) == 130
    finally:
        launcher.terminate()
        launcher.wait(DEADLINE)


def test_the_agent_and_the_node_of_ones_own_can_be_deployed(place):
    (agent, node), (_, _, agents, nodes) = blocks("python"), blocks("yaml")
    (place / "mine.py").write_text(agent)
    (place / "mine_too.py").write_text(node)
    deployment = (place / "deploy" / "arph.yaml").read_text()
    ours = "  - {role: joint/1, class: agents.joint:JointAgent}"
    assert ours in deployment
    text = deployment.replace(ours, agents.partition("agents:\n")[2])
    (place / "mine.yaml").write_text(f"{text}\n{nodes}")
    done = launched("msma-launch mine.yaml --speed 2", place)
    assert done.returncode == 0, done.stdout + done.stderr
    (run_folder,) = place.glob("runs/*")
    ticks = read_log(run_folder, "plant", "tick")
    commanded = 0.06 * sum(None not in (tick["age"] or [None])[:1] for tick in ticks)  # [s]
    assert commanded > 6.0
    assert ticks[-1]["q"][0] > 0.8 * 0.052 * commanded, "the agent turns its joint by 3 deg/s"
    (log,) = place.glob("runs/*/odometer.jsonl")
    end = json.loads(log.read_text().splitlines()[-1])
    assert (end["event"], end["code"]) == ("end", 0)


def test_the_robot_of_ones_own_loads(tmp_path):
    (tmp_path / "mine.yaml").write_text(blocks("yaml")[0])
    deployment = load(tmp_path / "mine.yaml")
    assert [agent.role for agent in deployment.agents] == ["joint/1", "joint/2", "joint/3"]


def test_the_pose_loads_in_a_deployment_and_turns(place):
    text = (place / "deploy" / "seven.yaml").read_text()
    kept = re.sub(r"^(tolerance|goal):.*\n( .*\n)*", "", text, flags=re.M)
    (place / "mine.yaml").write_text(f"{kept}\n{blocks('yaml')[1]}")
    goal = load(place / "mine.yaml").goal.build().piece(0.0)
    assert (goal.until, goal.free) == (9.0, "roll")
    assert goal.angular_velocity == pytest.approx([0.0, 0.0, 0.1745], abs=1e-4)


def test_what_it_links_to_is_there():
    for target in re.findall(r"\]\((?!https?:)([^)]+)\)", TEXT):
        assert (ROOT / target).exists(), target
