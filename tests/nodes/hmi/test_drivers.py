from nodes.hmi.drivers import Change, Drivers

IDLE = 5.0


def test_the_first_press_takes_the_driving_and_another_viewer_cannot() -> None:
    drivers = Drivers(IDLE)
    assert drivers.take(1, 0.0)
    assert not drivers.take(2, 1.0)
    assert drivers.take(1, 2.0)
    assert drivers.driver == 1


def test_it_is_free_after_the_idle_time_without_a_press() -> None:
    drivers = Drivers(IDLE)
    drivers.take(1, 0.0)
    assert drivers.look(5.0) is None
    assert drivers.look(5.1) == Change("drive.free")
    assert drivers.take(2, 5.2)


def test_a_press_takes_it_at_once_when_the_idle_time_is_over() -> None:
    drivers = Drivers(IDLE)
    drivers.take(1, 0.0)
    assert drivers.take(2, 6.0)


def test_a_takeover_is_asked_for_and_granted() -> None:
    drivers = Drivers(IDLE)
    drivers.take(1, 0.0)
    assert drivers.ask(2, 0.0) == Change("drive.asked", 2)
    assert drivers.answer(2, True, 0.5) is None  # not by who asks
    assert drivers.answer(1, True, 1.0) == Change("drive.granted", 2)
    assert drivers.driver == 2
    assert drivers.asking is None


def test_a_takeover_is_refused_or_forgotten() -> None:
    drivers = Drivers(IDLE)
    drivers.take(1, 0.0)
    drivers.ask(2, 0.0)
    assert drivers.answer(1, False, 1.0) == Change("drive.refused", 2)
    assert (drivers.driver, drivers.asking) == (1, None)
    drivers.ask(2, 2.0)
    assert drivers.ask(3, 2.5) is None
    for now in range(3, 14):
        drivers.take(1, float(now))
    assert drivers.asking is None


def test_who_asks_while_nobody_drives_drives() -> None:
    drivers = Drivers(IDLE)
    assert drivers.ask(2, 0.0) == Change("drive.granted", 2)
    assert drivers.driver == 2


def test_nobody_drives_after_a_stop_or_when_the_driver_has_left() -> None:
    drivers = Drivers(IDLE)
    drivers.take(1, 0.0)
    assert drivers.revoke() == Change("drive.free")
    assert drivers.revoke() is None
    drivers.take(2, 0.0)
    drivers.ask(3, 0.0)
    assert drivers.leave(3) is None
    assert drivers.asking is None
    assert drivers.leave(2) == Change("drive.free")
    assert drivers.driver is None
