"""How benches are run from the command line, and what they leave."""

import argparse
import json
from pathlib import Path

import pytest

from bench import bench_verb
from bench.bench import Bench, BenchError, Check, Result, Table
from bench.machine import CoreUsage, describe
from bench.registry import BENCHES, bench
from studies.study import Progress, Row


class Sample(Bench):
    """Measures nothing."""

    name, title = "sample", "A sample"
    passed, met = True, True

    def measure(self, size: float, progress: Progress) -> Result:
        """Return one of each."""
        return Result(
            checks=(Check("all done", "9 of 9", self.passed),),
            bars=(Row("fast", "at most 1 s", "0.5 s", self.met), Row("shown", "", "3")),
            tables=(Table("sides", ("side", "time"), (("a | b", "1 ms"),)),),
            notes=("a note",),
            data={"a": 1},
        )


def arguments(*words: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser()
    bench_verb.add_arguments(parser)
    return parser.parse_args(words)


@pytest.fixture
def sample(monkeypatch: pytest.MonkeyPatch) -> Sample:
    made = Sample()
    monkeypatch.setattr(bench_verb, "bench", lambda _: made)
    monkeypatch.setattr(bench_verb, "BENCHES", {"sample": ""})
    return made


def test_a_bench_writes_tables_and_numbers_with_the_machine(
    sample: Sample, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert bench_verb.run(arguments("all", "--out", str(tmp_path))) == 0
    text = (tmp_path / "bench.md").read_text()
    assert "| all done | 9 of 9 | yes |" in text
    assert "| fast | at most 1 s | 0.5 s | met |" in text
    assert "| a \\| b | 1 ms |" in text
    assert "cores" in text.splitlines()[2]
    told = json.loads((tmp_path / "sample.json").read_text())
    assert told["met"] is told["sound"] is True
    assert told["machine"]["cores"] >= 1
    assert told["data"] == {"a": 1}
    assert "1 of 1 bars met" in capsys.readouterr().out


def test_a_missed_bar_ends_with_3_and_work_that_was_not_done_with_1(
    sample: Sample, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    sample.met = False
    assert bench_verb.run(arguments("sample", "--out", str(tmp_path))) == bench_verb.MISSED == 3
    sample.passed = False
    assert bench_verb.run(arguments("sample", "--out", str(tmp_path))) == bench_verb.NOT_DONE == 1
    assert "THE WORK WAS NOT DONE" in " ".join(capsys.readouterr().out.split())


def test_a_wrong_name_or_size_is_refused_with_what_is_valid(tmp_path: Path) -> None:
    with pytest.raises(BenchError, match="no bench 'loops'; valid are loop"):
        bench_verb.run(arguments("loops"))
    with pytest.raises(BenchError, match="--size 0"):
        bench_verb.run(arguments("loop", "--size", "0"))
    (tmp_path / "file").write_text("")
    with pytest.raises(BenchError, match="--out"):
        bench_verb.run(arguments("loop", "--out", str(tmp_path / "file")))


@pytest.mark.parametrize("name", BENCHES)
def test_every_bench_has_a_name_and_a_title(name: str) -> None:
    assert bench(name).name == name
    assert bench(name).title


def test_the_machine_is_described() -> None:
    machine = describe()
    assert machine.libraries["eclipse-zenoh"] in machine.text()
    busy, stolen = CoreUsage().shares()
    assert 0 <= stolen <= 1
    assert 0 <= busy <= 1
