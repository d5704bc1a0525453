import json
import re
import threading
from pathlib import Path

import pytest

from runtime.processes.log_writer import LogError, LogWriter, new_run_folder


def lines(path: Path) -> list[dict[str, object]]:
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]


def test_every_line_has_wall_time_plant_time_and_event(tmp_path: Path) -> None:
    log = LogWriter(tmp_path / "run", "joint/2")
    log.write(1.5, "start", pid=7)
    log.close()
    (line,) = lines(tmp_path / "run" / "joint-2.jsonl")
    assert (line["t"], line["event"], line["pid"]) == (1.5, "start", 7)
    assert isinstance(line["wall"], float)


def test_a_revived_process_goes_on_in_the_same_file(tmp_path: Path) -> None:
    for life in ("first", "second"):
        log = LogWriter(tmp_path, "goal")
        log.write(0.0, life)
        log.close()
    assert [line["event"] for line in lines(tmp_path / "goal.jsonl")] == ["first", "second"]


def test_what_was_flushed_is_on_disk_should_the_process_be_killed(tmp_path: Path) -> None:
    log = LogWriter(tmp_path, "goal")
    log.write(0.0, "early")
    log.flush()
    log.write(0.0, "late")
    assert [line["event"] for line in lines(tmp_path / "goal.jsonl")] == ["early"]
    log.close()


def test_no_line_is_lost_between_threads(tmp_path: Path) -> None:
    log = LogWriter(tmp_path, "plant")

    def write() -> None:
        for tick in range(5000):
            log.write(float(tick), "tick")

    writer = threading.Thread(target=write)
    writer.start()
    while writer.is_alive():
        log.flush()
    log.close()
    assert [line["t"] for line in lines(tmp_path / "plant.jsonl")] == list(range(5000))


def test_two_runs_in_the_same_second_have_folders_of_their_own(tmp_path: Path) -> None:
    folders = {new_run_folder(tmp_path / "runs", "arph") for _ in range(3)}
    assert len(folders) == 3
    for folder in folders:
        assert folder.is_dir()
        assert re.fullmatch(r"arph-\d{8}-\d{6}(-\d)?", folder.name)


def test_a_folder_that_cannot_be_is_an_error_that_names_the_file(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(LogError, match=r"file/plant\.jsonl cannot be written: "):
        LogWriter(tmp_path / "file", "plant")
    with pytest.raises(LogError, match="cannot be written"):
        new_run_folder(tmp_path / "file", "arph")


def test_a_full_disk_is_complained_of_once_and_stops_nobody(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "plant.jsonl").symlink_to("/dev/full")
    log = LogWriter(tmp_path, "plant")
    for _ in range(3):
        log.write(0.0, "tick")
        log.flush()
    log.close()
    assert capsys.readouterr().err.count("No space left") == 1
