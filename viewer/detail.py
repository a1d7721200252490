"""How many triangles are drawn: all of them, or what a processor can draw sixty times a second."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import EmbeddedSurface, RigidSurface
from .simplify import simplified


@dataclass(frozen=True)
class Detail:
    """Most triangles drawn for the rigid parts together and for the skin; None for all."""

    rigid_triangles: int | None = None
    skin_triangles: int | None = None


FULL_DETAIL = Detail()
SOFTWARE_DETAIL = Detail(rigid_triangles=9_000, skin_triangles=5_000)
"""For Mesa's software renderers, whose time goes into small triangles."""


@dataclass(frozen=True, eq=False)
class DisplaySurface:
    """A rigid surface as it is drawn; fields as in RigidSurface, with its normals (vertex_count, 3)."""

    tissue: str
    frame: str
    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]
    normals: NDArray[np.float32]


def display_surfaces(surfaces: tuple[RigidSurface, ...], detail: Detail) -> tuple[DisplaySurface, ...]:
    """The rigid parts within the budget; their normals stay those of the full ones.

    A part's share grows with its area as well as its triangles: on large smooth bone an edge is seen
    sooner than on a tooth.
    """
    counts = np.array([len(s.triangles) for s in surfaces], dtype=float)
    if detail.rigid_triangles is None or counts.sum() <= detail.rigid_triangles:
        targets = counts
    else:
        wish = np.sqrt(counts * [_area(s) for s in surfaces])
        targets = np.minimum(counts, detail.rigid_triangles * wish / wish.sum())
    shown = []
    for s, target in zip(surfaces, targets, strict=True):
        vertices, triangles, normals = s.vertices, s.triangles, s.normals
        if target < len(triangles):
            kept, triangles = simplified(vertices, triangles, int(target))
            vertices, normals = vertices[kept], normals[kept]
        shown.append(DisplaySurface(s.tissue, s.frame, vertices, triangles, normals))
    return tuple(shown)


def _area(surface: RigidSurface) -> float:
    """Area of a surface [m^2]."""
    a, b, c = (surface.vertices[surface.triangles[:, k]] for k in range(3))
    return 0.5 * float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum())


def display_skin(skin: EmbeddedSurface, rest_nodes: NDArray[np.floating], detail: Detail) -> EmbeddedSurface:
    """The skin within the budget: some of its vertices, with their weights."""
    if detail.skin_triangles is None or len(skin.triangles) <= detail.skin_triangles:
        return skin
    kept, triangles = simplified(skin.vertices(rest_nodes), skin.triangles, detail.skin_triangles)
    return EmbeddedSurface(triangles=triangles, weights=skin.weights[kept])
