"""Reading the motion of a run from a log of several files."""

import json
import tracemalloc
from pathlib import Path

import numpy as np

from runtime.results.run_log import read_run_log
from tests.runtime.conftest import Robot


def tick(t: float, age: list[float | None]) -> str:
    numbers = {"hand": [t, 0.0, None], "q": [t] * 6, "base": [0.0] * 3, "base_velocity": [0.0] * 2}
    return json.dumps({"wall": 100.0 + t, "t": t, "event": "tick", **numbers, "age": age})


def turned(t: float, orientation: list[float | None]) -> str:
    return json.dumps(json.loads(tick(t, [])) | {"orientation": orientation})


def start(by: str) -> str:
    return json.dumps({"wall": 100.0, "t": 0.0, "event": "start", "by": by})


def write(file: Path, *lines: str) -> None:
    file.write_text("".join(f"{line}\n" for line in lines))


def test_the_motion_is_read_over_all_files_in_their_order(tmp_path: Path) -> None:
    write(tmp_path / "plant.2.jsonl", tick(2.0, [0.1, None]))
    write(tmp_path / "plant.10.jsonl", tick(3.0, [0.2, 0.3]))
    write(tmp_path / "plant.1.jsonl", start("a"), tick(1.0, []))
    write(tmp_path / "plant.jsonl", tick(4.0, [0.1, 0.1]), '{"event": "tick", "t": 5.0, "ha')
    log = read_run_log(tmp_path)
    assert log.t.tolist() == [1.0, 2.0, 3.0, 4.0]
    assert log.q.shape == (4, 6)
    assert np.isnan(log.hand[:, 2]).all()
    assert np.isnan(log.age).tolist() == [[True, True], [False, True], [False] * 2, [False] * 2]
    assert log.is_whole


def test_an_orientation_is_read_where_the_log_has_one(tmp_path: Path) -> None:
    write(
        tmp_path / "plant.jsonl",
        tick(1.0, []),  # an older log has none
        turned(2.0, [0.0, 0.0, 0.6, 0.8]),
        turned(3.0, [None] * 4),
    )
    log = read_run_log(tmp_path)
    nothing = [np.nan] * 4
    np.testing.assert_array_equal(log.orientation, [nothing, [0.0, 0.0, 0.6, 0.8], nothing])


def test_only_what_follows_the_last_start_counts(tmp_path: Path) -> None:
    write(tmp_path / "plant.1.jsonl", start("a"), tick(1.0, []), start("b"), tick(0.5, []))
    write(tmp_path / "plant.jsonl", tick(0.6, []))
    log = read_run_log(tmp_path)
    assert log.t.tolist() == [0.5, 0.6]
    assert [event["by"] for event in log.events] == ["b"]


def test_motion_is_read_in_a_few_times_the_memory_of_its_numbers(tmp_path: Path) -> None:
    many = 20_000
    write(tmp_path / "plant.jsonl", *(tick(float(t), [0.1] * 7) for t in range(many)))
    tracemalloc.start()
    log = read_run_log(tmp_path)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(log.t) == many
    assert most < 3 * many * 8 * 27  # bytes of the numbers of each line


def test_a_run_whose_early_motion_was_dropped_says_so_and_is_evaluated(robot: Robot) -> None:
    options = ["--set", "log_megabytes=1", "--set", "period=2ms", "--duration", "10s"]
    code, said = robot.run(*options, "--speed", "2")
    assert code in (0, 3), said
    assert "went over `log_megabytes`" in said
    assert robot.summary["evaluation"]["t"] >= 10.0 - 1e-6
    assert len(robot.log("plant", "start")) == 1  # which is in the part that was dropped
