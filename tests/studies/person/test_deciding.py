"""What a scripted person decides: how few presses bring a hand to a place if all goes well."""

import numpy as np
import pytest

from agents.agent import Array
from plant.urdf import load
from studies.person.button_sets import ButtonSet, OneSet, TwoSets
from studies.person.deciding import NEAR, Expert, Person

ARPH = load("arph")
START = np.array([*np.radians([0.0, 60.0, -115.0, 0.0, 0.0, 0.0]), 0.0, 0.0, 0.0])
PLACES = {
    "table": (1.1, 0.5, 0.75),
    "mouth": (0.4, -0.6, 1.1),
    "shelf": (1.6, 0.3, 0.35),
}
"""Where the hand is brought, one after the other [m]."""
HAND = TwoSets(ARPH).hands(START[None])[0]


def presses(
    buttons: ButtonSet, state: Array, place: Array, kind: type[Person] = Person
) -> tuple[list[str], Array]:
    """Return what is pressed until the hand is there, and the state then."""
    person, moves = kind(buttons), list[str]()
    while np.linalg.norm(buttons.hands(state[None])[0] - place) > NEAR:
        press = person.next_press(state, place)
        assert press is not None
        assert len(moves) < 20
        course = buttons.courses(state)[press.move]
        state = course.states[np.argmin(np.abs(course.amounts - press.amount))]
        moves.append(press.move)
    return moves, state


@pytest.mark.parametrize("name", PLACES)
@pytest.mark.parametrize("kind", [Person, Expert])
def test_one_set_takes_a_press_for_each_direction(name: str, kind: type[Person]) -> None:
    moves, _ = presses(OneSet(), HAND, np.array(PLACES[name]), kind)
    assert len(moves) == 3


def total(kind: type[Person]) -> int:
    """Return the presses to all places with two sets, of platform and arm."""
    state, all_moves = START, list[str]()
    for place in PLACES.values():
        moves, state = presses(TwoSets(ARPH), state, np.array(place), kind)
        all_moves += moves
    assert any(move.startswith("joint/") for move in all_moves)
    assert any(not move.startswith("joint/") for move in all_moves)
    return len(all_moves)


def test_two_sets_take_more_and_an_expert_fewer_of_them() -> None:
    assert 3 * len(PLACES) == 9  # docs/operator.md names these
    assert (total(Person), total(Expert)) == (26, 13)


def test_what_is_in_reach_of_one_press_is_pressed_once() -> None:
    one, two = OneSet(), TwoSets(ARPH)
    assert presses(one, HAND, HAND - [0.0, 0.3, 0.0])[0] == ["right"]
    turned = START + np.eye(len(START))[-1] * 0.4
    assert presses(two, START, two.hands(turned[None])[0])[0] == ["left"]


def test_who_knows_that_a_button_does_more_at_least_presses_another_one() -> None:
    person, place = Person(TwoSets(ARPH)), np.array(PLACES["table"])
    first = person.next_press(START, place)
    assert first is not None
    person.least = {first.move: first.amount + 1.0}
    second = person.next_press(START, place)
    assert second is not None
    assert second.move != first.move or second.amount >= first.amount + 1.0


def test_somebody_who_is_there_has_nothing_to_press() -> None:
    assert Person(OneSet()).next_press(HAND, HAND) is None


@pytest.mark.parametrize("move", TwoSets(ARPH).courses(START))
def test_the_amount_of_a_press_is_seen_from_where_it_led(move: str) -> None:
    two = TwoSets(ARPH)
    course = two.courses(START)[move]
    index = min(50, len(course.amounts) - 1)
    done = two.amount(move, START, course.states[index])
    assert done == pytest.approx(course.amounts[index], abs=1e-9)


def test_the_best_that_one_more_press_can_do_is_what_it_does() -> None:
    two, place = TwoSets(ARPH), np.array(PLACES["table"])
    best = min(
        np.linalg.norm(two.hands(course.states) - place, axis=-1).min()
        for course in two.courses(START).values()
    )
    assert two.after_one_more(START[None], place)[0] == pytest.approx(best, abs=2e-3)
