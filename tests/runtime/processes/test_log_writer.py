import json
import os
import re
import threading
from contextlib import suppress
from pathlib import Path

import pytest

from runtime.processes.log_writer import LogError, LogWriter, new_run_folder, numbered_parts
from runtime.results.logs import log_lines, read_log
from runtime.wire import topics
from runtime.wire.messages import Diag, Spread
from runtime.wire.packing import pack
from tests.runtime.conftest import ProcessGroup


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
    assert log.flush(60.0)
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


SMALL = 0.08  # [MB]: 10 kB a file


def tick(t: int) -> str:
    return json.dumps({"wall": float(t), "t": float(t), "event": "tick", "hand": [0.1] * 50})


def write_ticks(folder: Path, ticks: int, at_once: int) -> None:
    """Write a small log, so many ticks in a piece."""
    log = LogWriter(folder, "plant", SMALL)
    for t in range(ticks):
        log.line(tick(t))
        if t % at_once == at_once - 1:
            assert log.flush(30.0)
    log.close()


def test_a_log_takes_no_more_than_its_limit_and_keeps_the_newest(tmp_path: Path) -> None:
    write_ticks(tmp_path, 2000, 20)
    files = list(tmp_path.iterdir())
    assert sum(file.stat().st_size for file in files) < 1.3 * SMALL * 1e6
    kept = [line["t"] for line in log_lines(tmp_path, "plant", "tick")]
    assert kept == list(range(2000 - len(kept), 2000))
    assert len(kept) > 100


def test_a_log_that_is_written_in_large_pieces_takes_no_more(tmp_path: Path) -> None:
    write_ticks(tmp_path, 600, 100)
    assert sum(file.stat().st_size for file in tmp_path.iterdir()) < 1.1 * SMALL * 1e6


def test_events_outlive_the_motion_that_is_dropped(tmp_path: Path) -> None:
    log = LogWriter(tmp_path, "plant", SMALL)
    for t in range(2000):
        log.line(tick(t))
        if t % 100 == 0:
            log.write(float(t), "obeys", role="joint/1")
            assert log.flush(30.0)
    log.close()
    assert [line["t"] for line in read_log(tmp_path, "plant", "obeys")] == list(range(0, 2000, 100))
    assert read_log(tmp_path, "plant", "dropped")


def test_a_revived_process_goes_on_with_the_numbers_of_the_files(tmp_path: Path) -> None:
    for life in range(4):
        log = LogWriter(tmp_path, "plant", 2 * SMALL)
        for t in range(100):
            log.line(tick(100 * life + t))
        log.close()
    assert [line["t"] for line in log_lines(tmp_path, "plant", "tick")] == list(range(400))
    assert list(numbered_parts(tmp_path / "plant.jsonl")) == [1, 2, 3, 4]


def test_two_copies_of_a_process_write_to_one_log(tmp_path: Path) -> None:
    first, second = (LogWriter(tmp_path, "joint/1", SMALL) for _ in range(2))
    for t in range(0, 200, 2):
        first.line(tick(t))
        assert first.flush(30.0)
        second.line(tick(t + 1))
        assert second.flush(30.0)
    first.close()
    second.close()
    assert [line["t"] for line in log_lines(tmp_path, "joint/1", "tick")] == list(range(200))


def test_a_disk_that_hangs_delays_neither_the_writer_nor_the_end(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "plant.jsonl")
    nobody_reads = os.open(tmp_path / "plant.jsonl", os.O_RDWR)
    log = LogWriter(tmp_path, "plant")
    for t in range(1000):
        log.line(tick(t))
    assert not log.flush(0.1)  # the pipe is full
    log.write(0.0, "end")
    log.close()
    os.set_blocking(nobody_reads, False)
    while any(thread.name == "log" for thread in threading.enumerate()):
        with suppress(BlockingIOError):
            os.read(nobody_reads, 1 << 20)
    os.close(nobody_reads)


def test_the_end_of_a_run_is_noticed_while_the_disk_hangs(processes: ProcessGroup) -> None:
    processes.run.mkdir()
    os.mkfifo(processes.run / "plant.jsonl")
    nobody_reads = os.open(processes.run / "plant.jsonl", os.O_RDWR)
    processes.options += ["--set", "period=2ms", "--set", "duration=2s"]
    processes.start("plant", "goal", "joint/2")
    for role in ("plant", "goal", "joint/2"):
        code, said = processes.result(role, 40.0)
        assert code == 0, said
        assert "the run is over" in said
    os.close(nobody_reads)


@pytest.mark.skipif(os.geteuid() != 0, reason="to make a folder of another user takes root")
def test_no_log_goes_to_a_folder_of_another_user_that_is_named_on_the_bus(
    processes: ProcessGroup, tmp_path: Path
) -> None:
    foreign = tmp_path / "foreign"
    foreign.mkdir()
    os.chown(foreign, 65534, 65534)
    bus = processes.visit()
    lie = Diag(
        t=0.0,
        role="plant",
        host="host",
        pid=1,
        state="runs",
        rate=0.0,
        work=Spread(0.0, 0.0, 0.0),
        answers={},
        refused={},
        perception="none",
        run=str(foreign),
        deployment="x.yaml",
        version="1",
        clock=0,
    )
    bus.answer(topics.diag("plant"), lambda _: pack(lie))
    processes.start("joint/2", more=("--set", f"runs={tmp_path / 'own'}"))
    diag = processes.until(bus, "joint/2", lambda diag: bool(diag.run), "it says where it logs")
    assert Path(diag.run).parent == tmp_path / "own"
    assert not list(foreign.iterdir())
