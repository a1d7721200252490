"""The rigid parts as one mesh, with what each vertex needs to be shaded."""

from collections.abc import Iterable

import moderngl
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from .ambient_occlusion import Occluder, ambient_occlusion
from .detail import DisplaySurface
from .tissues import tissue_index

VERTEX_LAYOUT = ("3f 3f 4f", "in_position", "in_normal", "in_kind")

_GUM_REACH = (0.0020, 0.0080)  # [m]: mucosa nearer to a tooth is gum, farther is not
_BURIED = (0.0, 0.0012)  # [m]: a tooth this deep in mucosa is not seen as a tooth


def vertex_data(context: moderngl.Context, surfaces: tuple[DisplaySurface, ...]) -> NDArray[np.float32]:
    """VERTEX_LAYOUT of all vertices, (vertex_count, 10).

    in_kind: ambient occlusion, index into TISSUES, 1 if in the jaw frame, gum. The last is 1 for mucosa
    that covers teeth and for roots that mucosa covers, 0 away from them.
    """
    rows = [np.zeros((0, 10))]
    for surface in surfaces:
        itself = (Occluder(surface.vertices, surface.triangles),)
        kind = np.zeros((len(surface.vertices), 4))
        kind[:, 0] = ambient_occlusion(context, surface.vertices, surface.normals, itself)
        kind[:, 1] = tissue_index(surface.tissue)
        kind[:, 2] = surface.frame == "jaw"
        kind[:, 3] = _gum(surface, surfaces)
        rows.append(np.hstack([surface.vertices, surface.normals, kind]))
    return np.concatenate(rows).astype(np.float32)


def _gum(surface: DisplaySurface, surfaces: tuple[DisplaySurface, ...]) -> NDArray[np.float64]:
    """How much mucosa is gum, or how deep a tooth is in it, (vertex_count,) in [0, 1]."""
    other = {"mucosa": "tooth", "tooth": "mucosa"}.get(surface.tissue)
    others = [s for s in surfaces if s.tissue == other]
    if not others:
        return np.zeros(len(surface.vertices))
    points = np.concatenate([s.vertices for s in others])
    distance, nearest = cKDTree(points).query(surface.vertices)
    if surface.tissue == "mucosa":
        return 1.0 - _smoothstep(*_GUM_REACH, distance)
    normals = np.concatenate([s.normals for s in others])[nearest]
    return _smoothstep(*_BURIED, -np.einsum("ij,ij->i", surface.vertices - points[nearest], normals))


def _smoothstep(low: float, high: float, x: NDArray[np.float64]) -> NDArray[np.float64]:
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def merged_triangles(surfaces: Iterable[DisplaySurface]) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Triangles of all surfaces over their joined vertices, (n, 3), and the surface of each, (n,).

    Triangles that face away are not drawn, so an open surface gets both sides.
    """
    triangles, part, start = [np.zeros((0, 3), np.int32)], [np.zeros(0, np.int64)], 0
    for index, surface in enumerate(surfaces):
        t = surface.triangles.astype(np.int32) + np.int32(start)
        if not is_closed(surface.triangles):
            t = np.concatenate([t, t[:, ::-1]])
        triangles.append(t)
        part.append(np.full(len(t), index))
        start += len(surface.vertices)
    return np.concatenate(triangles), np.concatenate(part)


def is_closed(triangles: NDArray[np.integer]) -> bool:
    """Whether nearly every edge has a neighbour on its other side (a few cracks do not open a surface)."""
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    counts = np.unique(edges, axis=0, return_counts=True)[1]
    return bool(np.mean(counts == 1) < 0.005)
