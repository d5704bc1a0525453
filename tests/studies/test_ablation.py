from typing import Any

import pytest

from agents import platform, steering
from studies import ablation
from studies.ablation import TERMS, Ablation, Score, Term, arm_samples, without
from studies.study import Progress


@pytest.mark.parametrize("term", TERMS, ids=lambda term: term.name)
def test_each_term_is_off_for_a_while_and_then_as_before(term: Term) -> None:
    assert term.constants
    before = [_value(constant) for constant in term.constants]
    with without(term):
        assert [_value(constant) for constant in term.constants] == [term.off] * len(before)
    assert [_value(constant) for constant in term.constants] == before
    assert all(value != term.off for value in before)


def _value(constant: str) -> Any:
    owner, name = ablation._owner(constant)
    return getattr(owner, name)


def test_a_constant_that_two_modules_read_is_off_in_both() -> None:
    (term,) = (term for term in TERMS if term.constants[0].endswith("TRIFLE"))
    with without(term):
        assert vars(steering)["TRIFLE"] == vars(platform)["TRIFLE"] == term.off


def test_a_term_without_which_all_goes_as_well_misses_its_bar(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    useful, useless = TERMS[0], TERMS[1]

    def sample() -> Score:
        return Score(2 if useful.off == steering.POWER else 5, 6, 0.001)

    monkeypatch.setattr(ablation, "TERMS", (useful, useless))
    monkeypatch.setattr(ablation, "mobile_samples", lambda size: {"some": sample})
    monkeypatch.setattr(ablation, "arm_samples", lambda size: {})
    rows = Ablation().measure(1.0, Progress()).rows
    assert [row.met for row in rows[1:3]] == [True, False]
    assert "-3" in rows[1].measured


def test_the_arms_samples_run() -> None:
    score = arm_samples(0.05)["broken-joints"]()
    assert score.of == 2
