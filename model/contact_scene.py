"""What a tongue may touch, and at which of its surface nodes contact is looked for."""

from dataclasses import dataclass

from .contact_forces import CollisionPoints
from .signed_distance import SignedDistanceGrid


@dataclass(frozen=True, eq=False)
class ContactScene:
    """points: collision points of the tongue. grids: signed distance to the rigid parts, at most one a frame."""

    points: CollisionPoints
    grids: tuple[SignedDistanceGrid, ...]
