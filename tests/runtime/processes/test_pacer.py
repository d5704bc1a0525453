import pytest

from runtime.processes.timing import Pacer

PERIOD = 0.0625  # [s], a binary fraction so that sums are exact


class Clock:
    """A clock that moves when somebody sleeps, and then a little more than asked for."""

    def __init__(self, oversleep: float = 0.0) -> None:
        self.now = 50.0
        self.oversleep = oversleep

    def __call__(self) -> float:
        return self.now

    def sleep(self, seconds: float) -> None:
        self.now += seconds + self.oversleep


def turns(clock: Clock, pacer: Pacer, count: int, work: float = 0.0) -> list[float]:
    times = []
    for _ in range(count):
        times.append(pacer.wait())
        clock.now += work
    return times


@pytest.mark.parametrize("oversleep", [0.0, 0.001])
def test_turns_keep_their_rate_however_badly_one_sleeps(oversleep: float) -> None:
    clock = Clock(oversleep)
    times = turns(clock, Pacer(PERIOD, clock, clock.sleep), 1000, work=0.02)
    assert times[-1] == pytest.approx(50.0 + 1000 * PERIOD, abs=0.002)


def test_one_late_turn_is_caught_up_with() -> None:
    clock = Clock()
    pacer = Pacer(PERIOD, clock, clock.sleep)
    turns(clock, pacer, 1)
    clock.now += 1.5 * PERIOD
    assert turns(clock, pacer, 3) == pytest.approx([50 + n * PERIOD for n in (2.5, 3, 4)])


def test_after_a_long_stop_there_is_no_burst() -> None:
    clock = Clock()
    pacer = Pacer(PERIOD, clock, clock.sleep)
    turns(clock, pacer, 1)
    clock.now += 50 * PERIOD
    assert turns(clock, pacer, 4) == pytest.approx([50 + n * PERIOD for n in (51, 52, 53, 54)])


def test_a_long_wait_ends_soon_after_the_end_has_come() -> None:
    clock = Clock()
    pacer = Pacer(10.0, clock, clock.sleep)
    assert pacer.wait(ended=lambda: clock.now > 50.5) < 50.7
