"""Files that are there whole or not at all."""

from pathlib import Path

import pytest

from runtime.atomic import write_atomically


def test_who_waits_for_a_file_never_reads_a_part_of_it(tmp_path: Path) -> None:
    file = tmp_path / "summary.json"

    def write_in_parts(new: Path) -> None:
        assert new.suffix == file.suffix
        with new.open("w") as out:
            for part in ("{", "}"):
                out.write(part)
                out.flush()
                assert not file.exists()

    write_atomically(file, write_in_parts)
    assert [*tmp_path.iterdir()] == [file]
    assert file.read_text() == "{}"


def test_where_it_cannot_be_written_what_was_there_before_stays_and_nothing_else(
    tmp_path: Path,
) -> None:
    file = tmp_path / "summary.json"
    file.write_text("{}")

    def write_half(new: Path) -> None:
        new.write_text("{")
        raise OSError(28, "No space left on device")

    with pytest.raises(OSError, match="No space left"):
        write_atomically(file, write_half)
    assert [*tmp_path.iterdir()] == [file]
    assert file.read_text() == "{}"
