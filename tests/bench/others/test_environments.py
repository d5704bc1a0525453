"""Environments of other systems: made once, with an error of one line if they cannot be made."""

import json
import sys
from pathlib import Path

import pytest

from bench.bench import BenchError
from bench.others.environments import cache, environment, run


def test_what_cannot_be_installed_is_reported_in_one_line(tmp_path: Path) -> None:
    fails = "import sys; sys.exit('looked everywhere\\nno matching distribution')"
    with pytest.raises(BenchError, match=r"^thing-1 cannot be made: .*: no matching distribution$"):
        run(tmp_path / "thing-1", sys.executable, "-c", fails)
    with pytest.raises(BenchError, match=r"^thing-1 cannot be made: .*No such file"):
        run(tmp_path / "thing-1", "/nowhere/python", "-m", "venv")


def test_an_existing_environment_is_used(tmp_path: Path) -> None:
    said: list[str] = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(
            "bench.others.environments._make",
            lambda root, python, requirements: (
                root.mkdir(),
                (root / "versions.json").write_text(json.dumps({"thing": "1"})),
            ),
        )
        for _ in range(2):
            python, versions = environment("thing", ("thing==1",), said.append, tmp_path)
        environment("thing", ("thing==2",), said.append, tmp_path)
    assert versions == {"thing": "1"}
    assert python.name == "python"
    assert len(said) == 2, "other requirements are another environment"


def test_environments_are_in_the_cache_folder(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", "/var/somewhere")
    assert cache() == Path("/var/somewhere/msma/bench")
