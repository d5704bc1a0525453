"""Settings of all tests: how many run at once, and how property tests judge time."""

import os
import socket
import time
from collections.abc import Generator
from contextlib import ExitStack

import pytest
from hypothesis import HealthCheck, settings

from tests.ports import reserve

# How long an example takes says nothing on a machine that has other work too.
settings.register_profile("tests", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("tests")


@pytest.hookimpl(optionalhook=True)  # without pytest-xdist one test runs after another
def pytest_xdist_auto_num_workers() -> int:
    """Return how many workers `-n auto` starts.

    Most tests wait for real processes most of the time, so there are two workers a core; four on a
    single core, for the same reason, and no more than eight, since the longest test sets the time.
    """
    return min(max(2 * len(os.sched_getaffinity(0)), 4), 8)


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: object) -> object:
    """Return what hands out the tests: `_TOGETHER` to one worker each, any other to who is free."""
    from xdist.scheduler import LoadScopeScheduling

    scheduling = LoadScopeScheduling(config, log)
    scheduling._split_scope = lambda test: next(filter(test.startswith, _TOGETHER), (test,))[0]
    return scheduling


@pytest.hookimpl(wrapper=True, tryfirst=True)  # so that no timeout counts the time of waiting
def pytest_runtest_protocol(item: pytest.Item) -> Generator[None, object, object]:
    """Run no more tests at once on this machine than there are workers, whoever has started them.

    Robots run in real time. If several people test at once, each test takes its turn, or there
    would be too many robots for the processors. Of the tests of benches there is only one at a
    time: they keep all processors busy.
    """
    with ExitStack() as stack:
        if item.nodeid.startswith("tests/bench/"):
            stack.enter_context(_turn(("bench",)))
        stack.enter_context(_turn(_TURNS))
        return (yield)


def _turn(names: tuple[str, ...]) -> socket.socket:
    """Wait until one of the turns of these names is free, and take it."""
    while not (turn := next(filter(None, map(reserve, names)), None)):
        time.sleep(0.05)
    return turn


_TOGETHER = (
    ("tests/agents/", "tests/plant/", "tests/studies/"),
    ("tests/bench/",),
    ("tests/nodes/hmi/browser/",),
    ("tests/nodes/hmi/test_listening.py",),
    ("tests/runtime/gate/test_operator_input.py",),
    ("tests/runtime/watching/test_verbs.py",),
    ("tests/runtime/wire/test_security.py",),
)
"""What one worker runs, one test after another: all that computes, or drives a browser, and files
whose tests share a robot. Four browsers, or long computations, at once on two cores would leave
nothing to robots, which run in real time."""
_TURNS = tuple(f"turn-{number}" for number in range(pytest_xdist_auto_num_workers()))
