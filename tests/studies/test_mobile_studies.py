from functools import cache
from pathlib import Path

import numpy as np

from studies.fault_cells import (
    MID,
    Cells,
    Map,
    oracle,
    outcome,
    pair_locks,
    simulate,
    single_locks,
)
from studies.fault_map import map_rows, misses
from studies.lockstep import Trace
from studies.mobile import DURATION, HAND, PERIOD, msma, plant
from studies.paper_faults import cases, run_cases
from studies.platform_path import PlatformPath, drive
from studies.report import Report, as_json
from studies.study import Findings, Progress


@cache
def one_lock() -> tuple[Cells, Trace]:
    """Return some cells with a lock in mid-path, and their runs."""
    cells = single_locks(MID).part(slice(16, 60, 8))
    return cells, simulate(cells)


@cache
def one_lock_map() -> Map:
    """Return the map of these cells."""
    cells, trace = one_lock()
    return Map(cells, outcome(cells, trace, oracle(cells)))


@cache
def two_locks() -> tuple[Cells, Trace]:
    """Return some cells with two locks, and their runs."""
    cells = pair_locks().part(slice(400, 404))
    return cells, simulate(cells)


def test_the_arm_starts_with_its_hand_where_table_1_says() -> None:
    np.testing.assert_allclose(plant().truth().position, HAND, atol=0.001)


def test_msma_follows_the_papers_path_and_never_goes_backwards() -> None:
    found = drive("MSMA", msma(), PERIOD, DURATION)
    assert found.error[0] < 0.003
    assert found.reversal == 0.0
    assert found.cusps == 0


def test_every_reading_of_the_papers_faults_is_a_case() -> None:
    yaws = sorted(round(float(np.degrees(case.q[0]))) for case in cases())
    assert yaws == [-60, -30, 0, 0, 30, 60, 120, 150]
    short = run_cases(cases(), PERIOD, 10.0)
    np.testing.assert_array_less(short.trace.error[-1, :5], 0.003)
    assert short.reversed.max() == 0.0


def test_the_studies_tables_and_pictures_come_with_their_bars(tmp_path: Path) -> None:
    study = PlatformPath()
    found = study.measure(0.01, Progress())
    assert {row.met for row in found.rows} >= {True, None}
    assert as_json(Report(study.name, study.title, found, (), 1.0, 0.01))
    (picture,) = study.draw(found, tmp_path)
    assert picture.stat().st_size > 10_000


def test_a_cell_runs_alike_alone_and_in_a_batch() -> None:
    cells, together = one_lock()
    alone = simulate(cells.part(slice(1, 2)))
    np.testing.assert_allclose(together.hand[:, 1], alone.hand[:, 0], atol=1e-6)


def test_the_map_shows_what_is_reachable_and_what_msma_reaches() -> None:
    cells, found = one_lock_map()
    assert cells.labels[1] == "joint/1:locked=60deg at 8 s"
    assert found.reachable.tolist() == [True, True, True, False, True, True]
    assert found.success[:2].all()
    assert not found.success[3]


def test_no_pair_with_shoulder_and_elbow_locked_is_reachable() -> None:
    cells = pair_locks().part(slice(2000, None, 40))
    possible, high = oracle(cells)
    assert np.isinf(possible).all()
    assert not high.any()


def test_the_tables_of_the_maps_can_be_written(tmp_path: Path) -> None:
    rows = map_rows(one_lock_map(), 1.0)
    found = Findings(tuple(rows), (), ())
    assert as_json(Report("fault-map", "", found, (), 1.0, 1.0))


def test_a_map_without_a_reachable_cell_misses_its_bar() -> None:
    cells = single_locks(MID).part(slice(16, 24, 8))
    found = Map(cells, outcome(cells, simulate(cells), (np.full(1, np.inf), np.ones(1, bool))))
    rows = {row.what: row.met for row in map_rows(found, 0.95)}
    assert rows[f"end within 3 mm, {cells.name}"] is False
    assert rows[f"farthest in reverse, {cells.name}"] is None


def test_each_miss_of_the_map_is_listed_with_its_reason() -> None:
    cells, trace = two_locks()
    none = np.zeros(4, dtype=bool)
    o = outcome(cells, trace, (np.zeros(4), ~none))
    o = o._replace(
        final=np.array([0.001, 0.010, 0.020, 0.030]),
        coming=np.array([False, True, False, False]),
        slides=np.array([0.1, 0.1, 2.0, 0.1]),
    )
    said = misses(Map(cells, o))
    assert "1 where the hand is near the top" in said
    assert f"({cells.labels[2]}: 20 mm)" in said
    assert "1 where it is still approaching" in said
    assert "1 where neither holds" in said
    assert cells.labels[0] not in said


def test_how_steeply_the_last_joint_lifts_the_hand_is_that_of_its_circle() -> None:
    cells, trace = two_locks()
    assert np.isnan(cells.locks).sum() == 4
    slides = outcome(cells, trace, (np.zeros(4), np.ones(4, dtype=bool))).slides
    assert (np.isfinite(slides) & (slides > 0)).all()
    free = single_locks(MID).part(slice(0, 2))  # shoulder and elbow are both left
    assert np.isnan(
        outcome(free, simulate(free), (np.zeros(2), np.ones(2, dtype=bool))).slides
    ).all()
