"""Files that cannot be written."""

from pathlib import Path

import pytest

from runtime.results.summary import save


def test_a_file_that_can_be_written_gives_no_message(tmp_path: Path) -> None:
    file = tmp_path / "summary.json"
    assert save(file, lambda file: file.write_text("{}")) == ""
    assert file.read_text() == "{}"


def test_a_full_disk_is_reported_in_a_line_that_names_the_file(tmp_path: Path) -> None:
    file = tmp_path / "summary.json"
    said = save(file, lambda _: Path("/dev/full").write_text("{}"))
    assert said.strip() == f"{file} cannot be written: No space left on device"


def test_no_partial_file_is_left(tmp_path: Path) -> None:
    def write_half(file: Path) -> None:
        file.write_text("{")
        raise OSError(28, "No space left on device")

    assert "No space left" in save(tmp_path / "summary.json", write_half)
    assert not [*tmp_path.iterdir()]


def test_other_errors_are_not_caught(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError):
        save(tmp_path / "summary.json", lambda _: 1 / 0)
