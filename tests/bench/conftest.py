"""Benches in tests take ports that no other test uses, and have no priority over other tests."""

import sys
from collections.abc import Iterator
from contextlib import ExitStack

import pytest

from bench.echo.runner import module
from runtime.spawning.ports import is_taken
from runtime.wire.mesh import ALL_BASES
from tests.ports import reserve

FORKSERVER = "bench.echo.forkserver"
NORMAL = (
    "from runtime.processes import scheduling; scheduling.set_realtime = lambda: False; "
    f"from {FORKSERVER} import main; main()"
)


@pytest.fixture(autouse=True)
def _ports_of_its_own(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    with ExitStack() as reservations:

        def taken(port: int) -> bool:
            if port in ALL_BASES:
                reservation = reserve(port)
                if reservation is None:
                    return True
                reservations.enter_context(reservation)
            return is_taken(port)

        monkeypatch.setattr("bench.machine.is_taken", taken)
        yield


@pytest.fixture(autouse=True)
def _normal_priority(monkeypatch: pytest.MonkeyPatch) -> None:
    """As root, they would leave nothing to the robots and browsers of other tests for seconds."""

    def command(name: str) -> list[str]:
        return [sys.executable, "-P", "-c", NORMAL] if name == FORKSERVER else module(name)

    monkeypatch.setattr("bench.echo.runner.module", command)
    monkeypatch.setattr("bench.others.processes.set_realtime", lambda: False)
