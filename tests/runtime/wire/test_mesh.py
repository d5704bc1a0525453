from itertools import combinations

import pytest

from runtime.wire.mesh import FIRST_COPY, SLOTS, Address, Endpoints, Mesh, on_loopback, port_base

BASE = 9000
ROBOT, ARM, BACK = "10.0.0.1", "10.0.0.2", "fd00::3"
HOMES = (ROBOT, BACK, ARM, ARM, ARM, BACK)
HOSTS = (ROBOT, ARM, BACK)
COPIES = ((FIRST_COPY, ROBOT), (FIRST_COPY, ARM), (FIRST_COPY + 1, ARM), (FIRST_COPY + 2, BACK))


def places(mesh: Mesh) -> list[Endpoints]:
    """Return the places of all roles and some copies."""
    roles = [mesh.endpoints(slot) for slot in range(len(mesh.homes))]
    return roles + [mesh.copy_endpoints(slot, home) for slot, home in COPIES if home in mesh.homes]


def dialled(place: Endpoints) -> tuple[Address, ...]:
    return (*place.dials, *place.rarely)


@pytest.mark.parametrize(
    ("one", "other"),
    list(combinations(places(Mesh(BASE, HOMES, HOSTS)), 2)),
    ids=lambda place: str(place.listen),
)
def test_of_every_two_processes_one_dials_the_other_wherever_they_are(
    one: Endpoints, other: Endpoints
) -> None:
    assert (one.listen in dialled(other)) != (other.listen in dialled(one))


def test_a_process_listens_at_its_host_s_address() -> None:
    mesh = Mesh(BASE, HOMES, HOSTS)
    assert [mesh.endpoints(slot).listen.host for slot in range(len(HOMES))] == list(HOMES)
    assert str(mesh.endpoints(1).listen) == f"[fd00::3]:{BASE + 1}"
    assert mesh.copy_endpoints(FIRST_COPY, ARM).listen == Address(ARM, BASE + FIRST_COPY)


def test_a_tool_dials_every_place_and_is_dialled_by_none() -> None:
    mesh = Mesh(BASE, HOMES, HOSTS)
    tool = mesh.visitor()
    assert tool.listen.port == 0
    assert {place.listen for place in places(mesh)} <= set(dialled(tool))


def test_a_process_knows_how_many_are_on_other_hosts() -> None:
    mesh = Mesh(BASE, HOMES, HOSTS)
    assert [mesh.endpoints(slot).elsewhere for slot in (0, 1, 2)] == [5, 4, 3]
    assert mesh.visitor().elsewhere == len(HOMES)
    assert on_loopback(BASE).visitor().elsewhere == 0


def test_ports_are_below_those_that_systems_hand_out() -> None:
    bases = [port_base(f"robot-{number}") for number in range(1000)]
    assert min(bases) > 1024
    assert max(bases) + SLOTS <= 32768
    assert all((base - min(bases)) % SLOTS == 0 for base in bases)
