from itertools import combinations

import pytest

from runtime.wire.mesh import seat, visitor
from runtime.wire.ports import FIRST_COPY, SLOTS, port_base

BASE, ROLES = 9000, 9
SLOTS_IN_USE = [*range(ROLES), *range(FIRST_COPY, FIRST_COPY + 3)]


@pytest.mark.parametrize(("low", "high"), list(combinations(SLOTS_IN_USE, 2)))
def test_of_every_two_processes_the_higher_one_dials(low: int, high: int) -> None:
    below, above = seat(BASE, low, ROLES), seat(BASE, high, ROLES)
    assert below.listen in above.dials
    assert above.listen not in below.dials


def test_a_tool_dials_every_slot_and_is_dialled_by_none() -> None:
    tool = visitor(BASE)
    assert tool.listen == 0
    assert {seat(BASE, slot, ROLES).listen for slot in range(SLOTS)} <= set(tool.dials)


def test_ports_are_below_those_that_systems_hand_out() -> None:
    bases = [port_base(f"robot-{number}") for number in range(1000)]
    assert min(bases) > 1024
    assert max(bases) + SLOTS <= 32768
    assert all((base - min(bases)) % SLOTS == 0 for base in bases)
