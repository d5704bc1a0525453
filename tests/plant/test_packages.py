"""Robot descriptions in installed packages."""

import re
from pathlib import Path

import pytest

from plant.packages import find
from plant.robot import RobotError

FILES = ("robots/one/urdf/arm.urdf", "robots/two/urdf/arm.urdf", "robots/two/urdf/left_leg.urdf")


@pytest.fixture(autouse=True)
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A folder in which a package with three robots is installed."""
    record = tmp_path / "some_robots-1.0.dist-info" / "RECORD"
    record.parent.mkdir()
    record.write_text("".join(f"{file},sha256=x,1\n" for file in FILES))
    (record.parent / "METADATA").write_text("Metadata-Version: 2.1\nName: some-robots\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    return tmp_path


@pytest.mark.parametrize("file", ["one/urdf/arm.urdf", "left_leg.urdf"])
def test_a_file_is_found_by_the_end_of_its_path(package: Path, file: str) -> None:
    path = find("some-robots", file)
    assert str(path).startswith(str(package))
    assert str(path).endswith(file)


@pytest.mark.parametrize(
    ("file", "says"),
    [
        ("arm.urdf", f"has several files arm.urdf; give more of: {FILES[0]}, {FILES[1]}"),
        ("urdf/leg.urdf", f"has no file urdf/leg.urdf; it has {FILES[2]}"),
        ("g.urdf", "has no file g.urdf; it has "),
        ("hand.urdf", f"has no file hand.urdf; it has {', '.join(FILES)}"),
        (".", "has no file .; it has "),
    ],
)
def test_what_is_not_there_or_not_clear_is_refused_with_what_is(file: str, says: str) -> None:
    with pytest.raises(RobotError, match=re.escape(says)):
        find("some-robots", file)


def test_a_package_that_is_missing_is_said_how_to_install() -> None:
    with pytest.raises(RobotError, match="'no-robots' is not installed; `pip install no-robots`"):
        find("no-robots", "arm.urdf")
