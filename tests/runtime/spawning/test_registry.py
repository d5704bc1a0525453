"""The private registry of runs, whose files are trusted, and which ports a robot takes."""

import json
import os
import socket
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import msgspec
import pytest

from runtime.config.deployment import Deployment, load
from runtime.errors import RunError
from runtime.spawning import registry
from runtime.spawning.identity import ProcessId, start_line
from runtime.spawning.registry import (
    RegisteredRun,
    begin_run,
    forget,
    join_run,
    register,
    runs_of,
    why_not,
)
from runtime.spawning.trust import distrust
from runtime.wire.mesh import ALL_BASES, LOOPBACK
from tests.ports import reserve_any
from tests.runtime.conftest import ROOT

ANOTHER_USER = 12345
as_root = pytest.mark.skipif(os.geteuid() != 0, reason="only root can give files to another user")


@pytest.fixture(autouse=True)
def own_registry(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "registry"
    monkeypatch.setattr(registry, "_candidates", lambda: iter([folder]))
    return folder


@pytest.fixture
def deployment(tmp_path: Path) -> Iterator[Deployment]:
    """Return a deployment whose usual ports are free, with classes of its own."""
    (tmp_path / "modules").mkdir()
    (tmp_path / "modules" / "own.py").touch()
    loaded = load(ROOT / "deploy" / "arph.yaml")
    base, reservation = reserve_any()
    with pytest.MonkeyPatch.context() as patch, reservation:
        for module in ("runtime.config.deployment", "runtime.watching.discovery"):
            patch.setattr(f"{module}.port_base", lambda _: base)
        more = {"runs": tmp_path / "runs", "modules": tmp_path / "modules", "port": base}
        yield replace(loaded, **more)  # type: ignore[arg-type] # of several types


def test_a_run_is_found_by_its_robot_s_name_until_it_is_forgotten(deployment: Deployment) -> None:
    resolved, folder = begin_run(deployment)
    assert resolved == deployment == load(folder / "deployment.yaml")
    (run,) = runs_of("arph")
    assert (run.folder, run.port, run.process) == (folder, deployment.port, ProcessId.own())
    assert runs_of("another") == []
    forget("arph", folder)
    assert runs_of("arph") == []


def test_a_run_of_which_nothing_lives_is_forgotten(deployment: Deployment) -> None:
    _, folder = begin_run(deployment)
    forget("arph", folder)
    run = RegisteredRun.of(deployment, folder)
    dead = msgspec.structs.replace(run, process=ProcessId(os.getpid(), 1e9))
    register(dead)
    assert runs_of() == []
    assert list(registry.registry().glob("*.json")) == []


def test_a_run_goes_on_without_its_launcher_while_a_process_of_it_lives(
    deployment: Deployment,
) -> None:
    _, folder = begin_run(deployment)
    forget("arph", folder)
    run = RegisteredRun.of(deployment, folder)
    dead = msgspec.structs.replace(run, process=ProcessId(os.getpid(), 1e9))
    line = {"event": "start", **start_line("joint/1", "arph", folder)}
    (folder / "joint-1.jsonl").write_text(json.dumps(line) + "\n")
    register(dead)
    assert runs_of("arph") == [dead]


@pytest.mark.parametrize("part", ["deployment.yaml", "", "modules", "own.py"])
@pytest.mark.parametrize(
    "change",
    [
        pytest.param(lambda path: os.chmod(path, 0o777), id="writable"),
        pytest.param(lambda path: os.chown(path, ANOTHER_USER, 0), id="owned", marks=as_root),
    ],
)
def test_files_that_another_user_may_change_are_not_trusted(
    deployment: Deployment, part: str, change: Callable[[Path], None]
) -> None:
    _, folder = begin_run(deployment)
    modules = deployment.modules
    path = {"modules": modules, "own.py": modules / "own.py"}.get(part, folder / part)
    assert len(runs_of("arph")) == 1
    change(path)
    assert runs_of("arph") == []
    assert str(path) in why_not("arph")
    assert f"{folder}/deployment.yaml is not trusted" in why_not("arph")


def test_what_lies_behind_a_link_is_not_trusted(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "link").symlink_to("file")
    assert distrust(tmp_path / "file") is None
    assert distrust(tmp_path / "link") == f"{tmp_path}/link is a symbolic link"


def test_a_registry_that_others_can_write_is_not_used(own_registry: Path) -> None:
    own_registry.mkdir()
    own_registry.chmod(0o777)
    assert runs_of() == []


def test_a_process_by_hand_joins_the_robot_s_run_or_begins_one(deployment: Deployment) -> None:
    _, first = join_run(deployment)
    _, second = join_run(deployment)
    assert first == second
    _, third = join_run(replace(deployment, robot="another", port=ALL_BASES[0] + 1))
    assert third != first
    assert (third / "deployment.yaml").is_file()


def test_a_process_by_hand_has_the_ports_of_the_run_in_its_folder(
    deployment: Deployment, tmp_path: Path
) -> None:
    (tmp_path / "deployment.yaml").write_text(deployment.dump())
    with socket.create_server((LOOPBACK, deployment.port)):  # as its plant does
        assert join_run(deployment, tmp_path / "new")[0].port != deployment.port
        joined, folder = join_run(deployment, tmp_path)
        assert (joined.port, folder) == (deployment.port, tmp_path)


def test_a_process_by_hand_needs_no_class_of_another_role(
    deployment: Deployment, tmp_path: Path
) -> None:
    text = deployment.dump().replace("plant.kinematic:KinematicPlant", "not_here:Plant")
    (tmp_path / "deployment.yaml").write_text(text)
    assert "not_here:Plant" in text
    assert join_run(deployment, tmp_path)[0].port == deployment.port


def test_what_a_run_s_first_process_still_writes_is_read_by_no_other(
    deployment: Deployment, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By hand all are started at once, and those that come second looked into half a file."""
    write, there = Path.write_text, []

    def write_in_parts(path: Path, text: str, **more: str) -> int:
        write(path, text[: len(text) // 2], **more)
        there.append((tmp_path / "deployment.yaml").exists())
        return write(path, text, **more)

    monkeypatch.setattr(Path, "write_text", write_in_parts)
    join_run(deployment, tmp_path)
    assert there == [False]
    assert load(tmp_path / "deployment.yaml").dump() == deployment.dump()


def test_a_full_disk_is_said_and_leaves_nothing_half_written(
    deployment: Deployment, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    write = Path.write_text

    def write_half(path: Path, text: str, **more: str) -> int:
        write(path, text[: len(text) // 2], **more)
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "write_text", write_half)
    with pytest.raises(RunError, match="No space left"):
        join_run(deployment, tmp_path / "run")
    assert not [*(tmp_path / "run").iterdir()]


def test_a_robot_whose_ports_another_has_takes_the_next_and_keeps_them(
    deployment: Deployment,
) -> None:
    begin_run(deployment)
    other, _ = begin_run(replace(deployment, robot="another"))
    assert other.port != deployment.port
    assert other.port in ALL_BASES
    assert join_run(replace(deployment, robot="another"))[0].port == other.port


def test_a_robot_whose_ports_a_program_has_takes_the_next(deployment: Deployment) -> None:
    with socket.create_server((LOOPBACK, deployment.port + 3)):
        assert begin_run(deployment)[0].port != deployment.port


def test_a_port_that_the_file_sets_stays(deployment: Deployment) -> None:
    explicit = replace(deployment, port=deployment.port + 1)
    with socket.create_server((LOOPBACK, explicit.port)):
        assert begin_run(explicit)[0].port == explicit.port
