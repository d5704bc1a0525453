"""Key pairs on disk: how they are created, and messages about bad or missing ones."""

import os
import shutil
import stat
import subprocess
import sys
from datetime import UTC, datetime, timedelta
from pathlib import Path

import pytest

from runtime.cli import main
from runtime.config.deployment import load
from runtime.doctor.certificates import check_certificates
from runtime.doctor.machine import Grade
from runtime.tls.certificates import Authority, write_keys
from runtime.wire.mesh import LOOPBACK
from runtime.wire.security import OPERATOR, Credentials, names

ROOT = Path(__file__).parents[3]
FILE = "arph-secure.yaml"
NOW = datetime.now(UTC)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The current folder, with a deployment whose certificates are in `keys`."""
    shutil.copy(ROOT / "deploy" / FILE, tmp_path)
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def authority(folder: Path) -> Authority:
    """The authority that signed all certificates of the deployment."""
    authority = Authority("arph", 100)
    write_keys(folder / "keys", authority, names(load(FILE).roles), [LOOPBACK])
    return authority


def replace(name: str, authority: Authority, issued_to: str = "", **more: datetime) -> None:
    """Replace the key pair of a name."""
    pair = authority.issue(issued_to or name, [LOOPBACK], **more)
    files = Credentials(Path("keys"), name, ())
    files.certificate.write_text(pair.certificate)
    files.private_key.write_text(pair.private_key)


def found() -> str:
    """Return what the doctor says about the certificates."""
    findings = list(check_certificates(load(FILE)))
    return " | ".join(f"{one.grade.value}: {one.detail}" for one in findings)


def test_there_is_a_key_pair_for_each_role_and_one_for_operators(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["keys", "keys", FILE]) == 0
    assert capsys.readouterr().out == "keys: 10 key pairs, for 127.0.0.1, valid for 730 days\n"
    roles = ["plant", "goal", *(f"joint-{number}" for number in range(1, 7)), "platform"]
    wanted = {f"{name}.{kind}" for name in [*roles, OPERATOR] for kind in ("pem", "key")}
    assert {file.name for file in (folder / "keys").iterdir()} == {*wanted, "ca.pem"}
    assert found().startswith("ok: 10 in ")


def test_only_the_owner_can_read_the_folder_and_the_private_keys(folder: Path) -> None:
    before = os.umask(0)
    try:
        main(["keys", "keys", FILE])
    finally:
        os.umask(before)
    assert stat.S_IMODE((folder / "keys").stat().st_mode) == 0o700
    private = list((folder / "keys").glob("*.key"))
    assert {stat.S_IMODE(file.stat().st_mode) for file in private} == {0o600}


def test_certificates_hold_the_addresses_of_all_hosts(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["keys", "here", str(ROOT / "deploy" / "arph-hosts.yaml")])
    said = capsys.readouterr().out
    assert "for 127.0.0.1, 127.0.0.2, 127.0.0.3," in said
    assert "does not use them yet" in said


def test_files_are_replaced_only_on_request(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["keys", "keys", FILE])
    before = {file: file.read_bytes() for file in (folder / "keys").iterdir()}
    assert main(["keys", "keys", FILE]) == 2
    assert "--overwrite" in capsys.readouterr().err
    assert {file: file.read_bytes() for file in before} == before
    assert main(["keys", "keys", FILE, "--overwrite"]) == 0
    assert all(file.read_bytes() != data for file, data in before.items())


@pytest.mark.parametrize("days", ["0", "-1", "nan", "1e9"])
def test_a_validity_out_of_bounds_is_refused(
    folder: Path, days: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["keys", "keys", FILE, "--days", days]) == 2
    assert "--days" in capsys.readouterr().err
    assert not (folder / "keys").exists()


def test_a_folder_that_cannot_be_created_is_an_error(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "keys").write_text("no folder")
    assert main(["keys", "keys", FILE]) == 1
    assert "cannot be written" in capsys.readouterr().err


def test_without_certificates_nothing_starts_and_one_line_gives_the_command(
    folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["launch", FILE]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "there are no certificates in" in said
    command = said.partition("create them: msma ")[2].split()
    assert [file.name for file in folder.iterdir()] == [FILE]
    assert main(command) == 0
    assert found().startswith("ok")


def test_tools_give_the_command_too(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for verb in (["status"], ["stop"], ["agent", FILE, "joint/1"]):
        assert main([*verb, *(["--file", FILE] if len(verb) == 1 else [])]) == 2
        assert "create them: msma keys keys arph-secure.yaml" in capsys.readouterr().err


@pytest.mark.usefixtures("authority")
def test_a_missing_key_pair_is_named(folder: Path) -> None:
    (folder / "keys" / "joint-3.key").unlink()
    assert f"there is no {folder}/keys/joint-3.key; create them: msma keys --overwrite" in found()


def test_the_doctor_finds_an_expired_certificate(folder: Path, authority: Authority) -> None:
    end = NOW - timedelta(2)
    replace("joint/2", authority, begin=NOW - timedelta(9), end=end)
    day = end.astimezone().strftime("%Y-%m-%d")
    assert f"bad: {folder}/keys/joint-2.pem expired on {day}" in found()


def test_the_launcher_refuses_it_before_anything_starts(
    folder: Path, authority: Authority, capsys: pytest.CaptureFixture[str]
) -> None:
    replace("joint/2", authority, begin=NOW - timedelta(9), end=NOW - timedelta(2))
    assert main(["launch", FILE]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert "joint-2.pem expired" in said
    assert not (folder / "runs").exists()


def test_the_doctor_finds_a_certificate_that_is_not_valid_yet(authority: Authority) -> None:
    replace("plant", authority, begin=NOW + timedelta(2), end=NOW + timedelta(9))
    assert "plant.pem is not valid before" in found()
    assert "is the clock right?" in found()


def test_the_doctor_finds_a_certificate_for_another_name(authority: Authority) -> None:
    replace("joint/2", authority, issued_to="joint/1")
    assert "joint-2.pem belongs to joint/1, not to joint/2" in found()


def test_the_doctor_finds_a_certificate_for_another_address(
    folder: Path, authority: Authority
) -> None:
    write_keys(folder / "keys", authority, ["goal"], ["10.1.2.3", "::1", "arm.local"])
    said = "goal.pem is for another address than 127.0.0.1: 10.1.2.3, ::1, arm.local"
    assert said in found()


@pytest.mark.usefixtures("authority")
def test_the_doctor_finds_a_certificate_of_another_authority() -> None:
    replace("goal", Authority("arph", 100))
    assert "goal.pem is not signed by " in found()


@pytest.mark.usefixtures("authority")
def test_the_doctor_finds_a_private_key_of_another_certificate(folder: Path) -> None:
    shutil.copy(folder / "keys" / "goal.key", folder / "keys" / "plant.key")
    assert "plant.pem and " in found()
    assert "are not a key pair" in found()


@pytest.mark.usefixtures("authority")
def test_the_doctor_finds_a_file_that_is_not_a_certificate(folder: Path) -> None:
    (folder / "keys" / "ca.pem").write_text("nothing")
    assert "ca.pem is not a certificate" in found()


@pytest.mark.usefixtures("authority")
def test_the_doctor_finds_a_private_key_that_others_can_read(folder: Path) -> None:
    file = folder / "keys" / "operator.key"
    file.chmod(0o644)
    said = f"bad: {file} can be read by other users, who could act as operator; `chmod 600 {file}`"
    assert found() == said


def test_the_doctor_warns_of_certificates_that_expire_soon(folder: Path) -> None:
    write_keys(folder / "keys", Authority("arph", 20), names(load(FILE).roles), [LOOPBACK])
    (finding,) = check_certificates(load(FILE))
    assert finding.grade is Grade.WARN
    assert "valid until" in finding.detail


def test_a_host_needs_no_certificates_of_roles_elsewhere(folder: Path) -> None:
    text = (folder / FILE).read_text().replace("role: joint/2,", "role: joint/2, host: far,")
    (folder / FILE).write_text(f"{text}\nhosts: {{here: 127.0.0.1, far: 192.0.2.1}}\n")
    addresses = [LOOPBACK, "192.0.2.1"]
    write_keys(folder / "keys", Authority("arph", 100), names(load(FILE).roles), addresses)
    (folder / "keys" / "joint-2.key").unlink()
    assert found().startswith("ok: 9 in ")


def test_without_the_library_only_the_verb_that_needs_it_says_so(folder: Path) -> None:
    code = "import sys; sys.modules['cryptography'] = None; from runtime.cli import main; "
    asked = {
        "keys": f"exit(main(['keys', 'keys', '{FILE}']))",
        "rest": "import runtime.verbs.agent",
    }
    said = {
        what: subprocess.run(
            [sys.executable, "-c", code + how],
            env={**os.environ, "PYTHONPATH": str(ROOT)},
            capture_output=True,
            text=True,
        )
        for what, how in asked.items()
    }
    assert said["rest"].returncode == 0, said["rest"].stderr
    assert said["keys"].returncode == 2
    assert "pip install 'msma[keys]'" in said["keys"].stderr
