"""Benches in tests take ports that no other test uses."""

from collections.abc import Iterator
from contextlib import ExitStack

import pytest

from runtime.spawning.ports import is_taken
from runtime.wire.mesh import ALL_BASES
from tests.ports import reserve


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
