import numpy as np
import pytest

from agents.agent import Array
from agents.pursuit import Pursuit
from agents.scene import Scene


def number(value: float) -> Array:
    return np.asarray(value)


def seen(hand: tuple[float, float], missing: tuple[float, float]) -> Scene:
    zero, one = number(0.0), number(1.0)
    return Scene(
        hand=(number(hand[0]), number(hand[1]), zero),
        drift=(zero, zero, zero),
        missing=(number(missing[0]), number(missing[1]), zero),
        going=(number(0.1), zero, zero),
        heading=zero,
        ahead=(one, zero),
        linear=number(0.1),
        angular=zero,
        carried=number(hand[0]),
        aside=number(hand[1]),
        off=zero,
        speed=number(0.1),
    )


@pytest.mark.parametrize("missing", [(0.0, 0.0), (0.3, 0.0), (0.0, -0.2), (0.1, 0.2)])
def test_the_axles_place_is_as_far_off_as_the_goal_is_from_the_hand(
    missing: tuple[float, float],
) -> None:
    along, beside = Pursuit.place(
        seen((-0.4, 0.2), missing), (number(1.0), number(0.0)), number(-0.4), number(0.2)
    )
    assert (float(along), float(beside)) == pytest.approx(missing)


def test_at_its_place_and_with_its_speed_it_goes_on_as_it_does() -> None:
    pursuit = Pursuit(0.3, turns=2.0, agrees=4.0, catches_up=8.0)
    zero = number(0.0)
    linear, angular = pursuit.speeds(0.06, seen((-0.4, 0.0), (0.0, 0.0)), zero, zero, zero)
    assert (float(linear), float(angular)) == pytest.approx((0.1, 0.0))


def test_the_other_way_round_it_turns_on_the_spot() -> None:
    pursuit = Pursuit(0.3, turns=2.0, agrees=4.0, catches_up=8.0)
    zero = number(0.0)
    linear, angular = pursuit.speeds(0.06, seen((-0.4, 0.0), (0.0, 0.0)), zero, zero, number(3.0))
    assert float(linear) <= 1e-12
    assert float(angular) == pytest.approx(6.0)
