"""Key pairs that are copied to another host: those that it needs, as long as it needs them."""

import os
import shutil
import stat
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from runtime.config.deployment import Deployment, load
from runtime.config.overrides import Override
from runtime.launching.launcher import prepare
from runtime.spawning import remote
from runtime.spawning.remote import RemoteProcesses
from runtime.tls.certificates import Authority, write_keys
from runtime.wire.security import names
from tests.runtime.conftest import DEADLINE, ROOT, wait_for


@pytest.fixture
def deployment(tmp_path: Path) -> Deployment:
    """A deployment on three hosts, with certificates."""
    changes = {"security.keys": tmp_path / "keys", "runs": tmp_path / "runs", "robot": "far"}
    overrides = [Override("a test", path, str(value)) for path, value in changes.items()]
    deployment = load(ROOT / "deploy" / "arph-hosts.yaml", overrides)
    addresses = [host.address for host in deployment.hosts.values()]
    write_keys(tmp_path / "keys", Authority("far", 9), names(deployment.roles), addresses)
    return deployment


@contextmanager
def host(name: str, place: Path) -> "Iterator[subprocess.Popen[bytes]]":
    """Run `msma share` for a host, as ssh would."""
    process = subprocess.Popen(
        [sys.executable, "-m", "runtime.cli", "share", name],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        cwd=place,
        env={**os.environ, "PYTHONPATH": str(ROOT)},
    )
    try:
        yield process
    finally:
        process.kill()
        process.wait()
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                pipe.close()


def test_a_host_gets_the_key_pairs_of_its_own_roles_and_keeps_none(
    deployment: Deployment, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(remote, "_ANSWER", DEADLINE)  # a host of a busy machine may answer late
    there = tmp_path / "there"
    there.mkdir()
    deployment, run = prepare(deployment)
    with host("base", there) as process:
        shares = RemoteProcesses(run, {"base": process}, away=True)
        shares.start([one for one in deployment.processes if one.host == "base"][:1])
        keys = there / "runs" / "base" / run.name / "keys"
        wanted = {"ca.pem", "goal.pem", "goal.key", "platform.pem", "platform.key"}
        assert {file.name for file in keys.iterdir()} == wanted
        assert stat.S_IMODE((keys / "goal.key").stat().st_mode) == 0o600
        assert stat.S_IMODE(keys.stat().st_mode) == 0o700
        moved = load(there / "runs" / "base" / run.name / "deployment.yaml", only_role="goal")
        assert moved.security is not None
        assert moved.security.keys.path == keys
        shares.revive("joint/2", "base")
        assert (keys / "joint-2.key").is_file()
        shares.signal(9)  # type: ignore[arg-type]
        wait_for(lambda: not shares.ended() and not len(shares), "the end of all there")
        shares.tidy()
    assert list(there.rglob("*")) == []
    assert list(run.rglob("*.key")) == []


def test_a_host_that_loses_its_launcher_keeps_no_key_pairs_either(
    deployment: Deployment, tmp_path: Path
) -> None:
    there = tmp_path / "there"
    there.mkdir()
    deployment, run = prepare(deployment)
    with host("base", there) as process:
        assert process.stdin is not None
        RemoteProcesses(run, {"base": process}, away=True).start([])
        assert (there / "runs" / "base" / run.name / "keys" / "goal.key").is_file()
        process.stdin.close()
        process.wait(10)
    assert list(there.rglob("*.key")) == []


def test_a_host_with_the_key_pairs_of_its_own_roles_can_start_them(
    deployment: Deployment, tmp_path: Path
) -> None:
    (tmp_path / "keys" / "plant.key").unlink()
    deployment, folder = prepare(deployment, host="arm")
    shutil.rmtree(folder)
    with pytest.raises(ValueError, match=r"plant\.key"):
        prepare(deployment, host="robot")
    with pytest.raises(ValueError, match=r"plant\.key"):
        prepare(deployment)
