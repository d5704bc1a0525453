import pytest
from msgspec.structs import replace

from nodes.hmi.drivers import Drivers
from nodes.hmi.presses import End, Pictures, Presses, Situation
from nodes.hmi.protocol.incoming import Jog
from nodes.hmi.protocol.values import Times

TIMES = Times()
SHARED = Situation("shared", False, 0.1)
JOG = Jog(1, 1, "shared")


@pytest.fixture
def presses() -> Presses:
    return Presses(Drivers(TIMES.idle), TIMES)


def test_a_press_is_alive_while_its_jogs_come(presses: Presses) -> None:
    for turn in range(20):
        assert presses.jog(1, JOG, SHARED, turn * 0.2) == []
    assert presses.alive is not None
    assert (presses.alive.serial, presses.alive.began) == (1, 0.0)
    assert presses.alive.arrived == pytest.approx(3.8)


def test_a_press_whose_lease_ended_is_dead_for_good(presses: Presses) -> None:
    presses.jog(1, JOG, SHARED, 0.0)
    assert presses.expire(0.25) == []
    assert presses.expire(0.26) == [End(1, 1, "lease", began=True)]
    assert presses.jog(1, JOG, SHARED, 0.3) == []
    assert presses.alive is None
    presses.jog(1, replace(JOG, press=2), SHARED, 0.4)
    assert presses.alive is not None


def test_a_late_jog_ends_its_press_even_if_nobody_looked_meanwhile(presses: Presses) -> None:
    presses.jog(1, JOG, SHARED, 0.0)
    assert presses.jog(1, JOG, SHARED, 1.0) == [End(1, 1, "lease", began=True)]
    assert presses.alive is None


def test_a_press_that_was_released_is_dead_whatever_comes_late(presses: Presses) -> None:
    presses.jog(1, JOG, SHARED, 0.0)
    assert presses.let_go(1, 1) == [End(1, 1, "released", began=True)]
    presses.jog(1, JOG, SHARED, 0.1)
    assert presses.alive is None
    assert presses.let_go(1, 7) == []
    presses.jog(1, replace(JOG, press=7), SHARED, 0.2)
    assert presses.alive is None


def test_letting_go_of_another_press_ends_nothing(presses: Presses) -> None:
    presses.jog(1, replace(JOG, press=2), SHARED, 0.0)
    assert presses.let_go(1, 1) == presses.let_go(2, 2) == []
    assert presses.alive is not None


@pytest.mark.parametrize(
    ("situation", "why"),
    [
        (SHARED._replace(mode=None), "plant"),
        (SHARED._replace(halted=True), "halted"),
        (SHARED._replace(mode="rest"), "mode"),
        (SHARED._replace(mode="manual"), "mode"),
        (SHARED._replace(mode="automatic"), "mode"),
        (SHARED._replace(fits=False), "part"),
        (SHARED._replace(picture=0.51), "picture"),
        (SHARED._replace(picture=None), "picture"),
    ],
)
def test_a_press_is_refused_or_ended_and_then_dead(
    situation: Situation, why: str, presses: Presses
) -> None:
    assert presses.jog(1, JOG, situation, 0.0) == [End(1, 1, why, began=False)]
    assert presses.jog(1, JOG, SHARED, 0.1) == []
    assert presses.alive is None
    presses.jog(1, replace(JOG, press=2), SHARED, 0.2)
    assert presses.jog(1, replace(JOG, press=2), situation, 0.3) == [End(1, 2, why, began=True)]
    presses.jog(1, replace(JOG, press=2), SHARED, 0.4)
    assert presses.alive is None


def test_a_second_viewer_s_press_is_refused_and_the_first_s_goes_on(presses: Presses) -> None:
    presses.jog(1, JOG, SHARED, 0.0)
    assert presses.jog(2, JOG, SHARED, 0.1) == [End(2, 1, "driver", began=False)]
    assert presses.jog(2, JOG, SHARED, 0.15) == []
    assert presses.alive is not None
    assert presses.alive.viewer == 1


def test_another_button_of_the_same_viewer_takes_the_place_of_the_first(presses: Presses) -> None:
    presses.jog(1, JOG, SHARED, 0.0)
    assert presses.jog(1, replace(JOG, press=2), SHARED, 0.1) == [End(1, 1, "released", began=True)]
    assert presses.alive is not None
    assert (presses.alive.number, presses.alive.serial) == (2, 2)
    assert presses.jog(1, JOG, SHARED, 0.15) == []
    assert presses.alive.number == 2


def test_a_viewer_that_leaves_holds_nothing(presses: Presses) -> None:
    presses.jog(1, JOG, SHARED, 0.0)
    assert presses.leave(2) == []
    assert presses.leave(1) == [End(1, 1, "released", began=True)]


def test_a_picture_is_as_old_as_the_state_that_was_painted() -> None:
    pictures = Pictures(kept=4)
    assert pictures.age(1, 0.0) is None
    for number in range(1, 7):
        pictures.sent(number, number * 0.05, t=number * 0.1)
    assert pictures.age(6, 0.4) == pytest.approx(0.1)
    assert pictures.age(4, 0.4) == pytest.approx(0.2)
    assert pictures.age(1, 0.4) == pytest.approx(0.25)  # no longer kept: at least so old
    assert pictures.age(7, 0.4) is None  # made up
    picture = pictures.of(6)
    assert picture is not None
    assert picture.t == pytest.approx(0.6)
