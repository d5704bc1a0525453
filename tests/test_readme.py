"""The README stays true: every command and every piece of code in it is run."""

import os
import re
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
TEXT = (ROOT / "README.md").read_text()
BIN = Path(sys.executable).parent


def blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", TEXT, flags=re.DOTALL | re.MULTILINE)


def commands(block: str) -> list[str]:
    lines = (line.partition(" #")[0].strip() for line in block.splitlines())
    return [line for line in lines if line and not line.startswith(". ")]


MAKE, *LAUNCHES, RUNNING, SECURE, STUDY = blocks("sh")


@pytest.fixture
def place(tmp_path):
    """A folder with the deployment files of the project's own."""
    shutil.copytree(ROOT / "deploy", tmp_path / "deploy", ignore=shutil.ignore_patterns("keys"))
    return tmp_path


def run(command: str, place: Path) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        shlex.split(command), cwd=place, env=environment(), capture_output=True, text=True
    )


def environment() -> dict[str, str]:
    return {**os.environ, "PATH": f"{BIN}{os.pathsep}{os.environ['PATH']}"}


@pytest.mark.parametrize("command", commands(MAKE))
def test_the_commands_of_the_first_screen_are_those_of_the_makefile(command):
    done = run(f"{command} --dry-run", ROOT)
    assert done.returncode == 0, done.stderr
    wanted = {"make run": "msma-launch deploy/arph.yaml", "make test": "pytest"}
    assert wanted[command] in done.stdout


@pytest.mark.parametrize(
    "command", [line for block in (*LAUNCHES, STUDY) for line in commands(block)]
)
def test_a_command_that_needs_nothing_running_ends_well(command, place):
    done = run(command, place)
    assert done.returncode == 0, done.stdout + done.stderr


def test_keys_are_made_and_the_robot_runs_by_them(place):
    for command in commands(SECURE):
        done = run(command, place)
        assert done.returncode == 0, done.stdout + done.stderr
    assert "goal reached" in done.stdout


def test_a_running_robot_does_as_it_is_told_from_another_terminal(place):
    launcher = subprocess.Popen(
        [BIN / "msma-launch", "deploy/arph.yaml"],
        cwd=place,
        env=environment(),
        stdout=subprocess.DEVNULL,
    )
    try:
        until = time.monotonic() + 15
        while "runs" not in run("msma status", place).stdout:
            assert time.monotonic() < until, "the robot did not start"
        for command in commands(RUNNING):
            done = run(command, place)
            allowed = (0, 1) if command == "msma doctor" else (0,)  # it may well find something
            assert done.returncode in allowed, f"{command}: {done.stdout}{done.stderr}"
        assert launcher.wait(10) is not None
    finally:
        launcher.terminate()
        launcher.wait(10)


def test_the_agent_of_ones_own_can_be_deployed(place):
    (code,), (entry,) = blocks("python"), blocks("yaml")
    (place / "mine.py").write_text(code)
    deployment = (ROOT / "deploy" / "arph.yaml").read_text()
    ours = "  - {role: joint/1, class: agents.joint:JointAgent}"
    assert ours in deployment
    (place / "mine.yaml").write_text(deployment.replace(ours, entry.partition("agents:\n")[2]))
    done = run("msma-launch mine.yaml --speed 4 --robot mine", place)
    assert done.returncode == 0, done.stdout + done.stderr


def test_what_it_links_to_is_there():
    for target in re.findall(r"\]\((?!https?:)([^)]+)\)", TEXT):
        assert (ROOT / target).exists(), target
