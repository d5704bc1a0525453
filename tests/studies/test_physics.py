"""The study of the task with masses: its first cases, which are the paper's task itself."""

from pathlib import Path

import pytest

from studies.physics import CASES, SPEED, Physics
from studies.study import Progress

pytest.importorskip("mujoco", reason="needs MuJoCo: pip install 'msma[physics]'")


def test_the_task_is_followed_with_masses_as_without_and_drawn(tmp_path: Path) -> None:
    study = Physics()
    found = study.measure(2 / len(CASES), Progress())
    assert all(row.met is not False for row in found.rows if row.what != SPEED)
    assert list(found.traces) == ["no masses (kinematic plant)", "planar base"]
    (picture,) = study.draw(found, tmp_path)
    assert picture.read_bytes().startswith(b"\x89PNG")
