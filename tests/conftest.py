"""Settings of all tests: how many run at once, and how property tests judge time."""

import os

import pytest
from hypothesis import HealthCheck, settings

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
