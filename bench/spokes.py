"""Another topology to compare with: agents are linked to the plant and the goal source only."""

from runtime.wire.mesh import Endpoints, Mesh

HUBS = 2
"""The first roles of a deployment: the plant and the goal source."""


def use_spokes() -> None:
    """Let this process, and its copies, dial the hubs only, and no other agent."""
    full = Mesh.seat

    def seat(self: Mesh, slot: int) -> Endpoints:
        place = full(self, slot)
        return place._replace(dials=place.dials[:HUBS])

    Mesh.seat = seat  # type: ignore[method-assign] # only a bench does so
