"""Rigid parts of the mouth as closed bodies, which have an inside.

A piece of surface whose rim is short beside its size is a body with holes at most, and its inside is where
the winding number says so. A piece with a long rim is a sheet, such as a palate without the bone above it: the
side on which the tongue rests is outside, and the sheet becomes a plate of finite thickness behind itself.
"""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from ..model.errors import LingualError
from ..model.surface import RigidSurface, vertex_normal_operator, vertex_normals
from .tetrahedralise import agreeing_triangles, edge_use, enclosed_volume, merged

SHEET_THICKNESS = 8e-3
"""Thickness of the plate that a sheet becomes [m]; a point less deep than half of it is pushed back to the front."""

SHORT_RIM = 0.5
"""Length of a body's rims at most, as a share of the square root of its area (a sphere with one hole: 0.28 of
its radius)."""

Surface = tuple[NDArray[np.float64], NDArray[np.int32]]


def closed_body(part: RigidSurface, tongue: NDArray[np.float64], thickness: float = SHEET_THICKNESS) -> Surface:
    """Vertices (n, 3) [m] and outward triangles (m, 3) of a rigid part with all its pieces closed.

    tongue: points of the tongue's surface at rest (k, 3) [m], in the same frame: outside of every sheet.
    Raises LingualError for a part without triangles or with a coordinate that is not finite.
    """
    if not np.isfinite(part.vertices).all():
        raise LingualError(f"The rigid part '{part.name}' has a vertex that is not finite: repair its surface.")
    points, faces = merged(part.vertices, part.triangles)
    if len(faces) == 0:
        raise LingualError(f"The rigid part '{part.name}' has no triangle with an area: repair its surface.")
    joined, _ = edge_use(faces)
    if len(np.unique(_directed_edges(faces), axis=0)) < 3 * len(faces):
        faces = agreeing_triangles(faces.copy(), joined)
    graph = sp.csr_array((np.ones(len(joined)), joined.T), shape=(len(faces), len(faces)))
    piece_count, piece = connected_components(graph, directed=False)
    closed = [_closed_piece(points, faces[piece == n], cKDTree(tongue), thickness) for n in range(piece_count)]
    starts = np.cumsum([0, *(len(v) for v, _ in closed)])
    triangles = [t + start for (_, t), start in zip(closed, starts, strict=False)]
    return np.concatenate([v for v, _ in closed]), np.concatenate(triangles).astype(np.int32)


def _closed_piece(points: NDArray[np.float64], faces: NDArray[np.int32], tongue: cKDTree, thickness: float) -> Surface:
    used, compact = np.unique(faces, return_inverse=True)
    points, faces = points[used], compact.reshape(-1, 3).astype(np.int32)
    rim = _rim(faces)
    rim_length = np.linalg.norm(points[rim[:, 1]] - points[rim[:, 0]], axis=1).sum()
    normal, centroid = _face_normals(points, faces), points[faces].mean(axis=1)
    if rim_length <= SHORT_RIM * np.sqrt(0.5 * np.linalg.norm(normal, axis=1).sum()):
        turned = enclosed_volume(points - points.mean(axis=0), faces) < 0.0
        return points, faces[:, ::-1] if turned else faces
    distance, nearest = tongue.query(centroid)
    facing = np.einsum("ti,ti->t", normal, tongue.data[nearest] - centroid)
    if np.sum(facing / np.maximum(distance, 1e-6) ** 3) < 0.0:  # triangles close to the tongue decide
        faces = faces[:, ::-1]
    return _plate(points, faces, thickness)


def _plate(points: NDArray[np.float64], faces: NDArray[np.int32], thickness: float) -> Surface:
    """The sheet, a copy of it `thickness` behind, and walls between their rims."""
    count = np.int32(len(points))
    normals = vertex_normals(points, faces, vertex_normal_operator(len(points), faces))
    a, b = _rim(faces).T
    walls = np.concatenate([np.stack([b, a, a + count], axis=1), np.stack([b, a + count, b + count], axis=1)])
    behind = faces[:, ::-1] + count
    return np.concatenate([points, points - thickness * normals]), np.concatenate([faces, behind, walls])


def _directed_edges(faces: NDArray[np.int32]) -> NDArray[np.int32]:
    """The three edges of every triangle in its own sense, (3 triangles, 2)."""
    return faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)


def _rim(faces: NDArray[np.int32]) -> NDArray[np.int32]:
    """Edges that only one triangle has, in that triangle's sense, (k, 2)."""
    edges = _directed_edges(faces)
    _, inverse, count = np.unique(np.sort(edges, axis=1), axis=0, return_inverse=True, return_counts=True)
    return edges[count[inverse.reshape(-1)] == 1]


def _face_normals(points: NDArray[np.float64], faces: NDArray[np.int32]) -> NDArray[np.float64]:
    """Normals of twice the triangles' areas, (m, 3)."""
    a, b, c = (points[faces[:, i]] for i in range(3))
    return np.cross(b - a, c - a)
