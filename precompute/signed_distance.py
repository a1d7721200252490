"""Signed distance grids of a tongue's rigid parts, cached.

Each part is a closed body (`closed_bodies`); the distance to their union is the least of the parts' own. That
is exact outside; where two bodies overlap, it is the depth in the deeper one. Distances come from Warp's
closest-point queries, in full near the surfaces and interpolated from coarser grids elsewhere. The coefficients
stored are those of the quadratic spline that takes these distances (scipy.ndimage.spline_filter).
"""

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates, spline_filter

from ..kernels.signed_distance import FAR, mesh_distance_kernel
from ..model.signed_distance import FRAMES, SignedDistanceGrid
from ..model.surface import RigidSurface
from ..model.tongue_model import TongueModel
from .cache import Arrays, cached, digest
from .closed_bodies import SHEET_THICKNESS, Surface, closed_body
from .progress import Progress, silent

ALGORITHM_VERSION = 2
"""Part of the cache key: raise it when anything here or in closed_bodies.py changes the result."""

SPACING = 0.75e-3
"""Of the grids [m]: the edge of an incisor is twice as wide."""
REACH = 14e-3
"""How far the grids extend beyond the tongue at rest [m]: coils move up to 17 mm, and not outwards only."""
STAGE = "distance to jaw and palate"
REFINEMENTS = 3
"""Grids twice as fine each, of which only the first is computed in full."""
NEAR = 2.0 * np.sqrt(3.0)
"""Spacings from a surface within which distances are computed: no farther than the corners of the coarser cell,
so that a sign that is interpolated is right, as a distance changes by no more than the way."""
_CHUNK = 50_000  # points between two reports of progress


def signed_distance_grids(
    tongue: TongueModel, spacing: float = SPACING, progress: Progress = silent
) -> tuple[SignedDistanceGrid, ...]:
    """One grid for each frame that has rigid parts within the tongue's reach, from the cache when it is there."""
    boundary = tongue.mesh.nodes[tongue.mesh.boundary_nodes]
    grids = []
    for frame in FRAMES:
        parts = [part for part in tongue.rigid if part.frame == frame]
        if parts:
            arrays = _cached_grid(parts, boundary, spacing, progress)
            if arrays["values"].size:
                grids.append(SignedDistanceGrid(frame, arrays["lower"], spacing, arrays["values"]))
    return tuple(grids)


def _cached_grid(
    parts: list[RigidSurface], boundary: NDArray[np.float64], spacing: float, progress: Progress
) -> Arrays:
    key = {
        "algorithm": ALGORITHM_VERSION,
        "tongue": digest(boundary),
        "parts": [digest(part.vertices, part.triangles) for part in parts],
        "spacing": spacing,
        "reach": REACH,
        "thickness": SHEET_THICKNESS,
    }
    return cached("signed-distance", key, lambda: _build(parts, boundary, spacing, progress))


def _build(
    parts: list[RigidSurface], boundary: NDArray[np.float64], spacing: float, progress: Progress
) -> Arrays:
    bodies = [closed_body(part, boundary) for part in parts]
    corners = np.concatenate([vertices for vertices, _ in bodies])
    lower = np.maximum(boundary.min(axis=0) - REACH, corners.min(axis=0) - 3.0 * spacing)
    upper = np.minimum(boundary.max(axis=0) + REACH, corners.max(axis=0) + 3.0 * spacing)
    if np.any(upper <= lower):  # the parts lie out of reach
        return {"lower": lower, "values": np.zeros((0, 0, 0), dtype=np.float32)}
    return {"lower": lower, "values": distance_values(bodies, lower, upper, spacing, progress)}


def distance_values(
    bodies: list[Surface],
    lower: NDArray[np.float64],
    upper: NDArray[np.float64],
    spacing: float,
    progress: Progress = silent,
) -> NDArray[np.float32]:
    """Spline coefficients [m] of the distance to closed bodies from `lower` to `upper` or a little beyond.

    bodies: vertices [m] and outward triangles of each. Returns (nx, ny, nz) float32, `spacing` apart.
    """
    cells = np.maximum(np.ceil((upper - lower) / (2**REFINEMENTS * spacing)), 1).astype(int)
    solids = [_Body(*body) for body in bodies]
    values = np.empty((0, 0, 0), dtype=np.float32)
    for level in range(REFINEMENTS + 1):
        shape, step = 2**level * cells + 1, 2 ** (REFINEMENTS - level) * spacing
        values, near = _refined(values, shape, step)
        points = _grid_points(shape, lower, step).reshape(-1, 3)[near]
        values[near] = _union_distance(solids, points, progress, level / (REFINEMENTS + 1))
        values = values.reshape(shape)
    progress(STAGE, 1.0)
    return spline_filter(values, order=2, output=np.float32)


def _refined(
    values: NDArray[np.float32], shape: NDArray[np.integer], step: float
) -> tuple[NDArray[np.float32], NDArray[np.integer]]:
    """A grid's values interpolated to one twice as fine, flat, and which of them must be computed."""
    if values.size == 0:
        return np.empty(int(np.prod(shape)), dtype=np.float32), np.arange(int(np.prod(shape)))
    fine = map_coordinates(values, np.indices(tuple(shape)) / 2.0, order=1).ravel()
    return fine, np.flatnonzero(np.abs(fine) < NEAR * step)


def _grid_points(shape: NDArray[np.integer], lower: NDArray[np.float64], spacing: float) -> NDArray[np.float32]:
    axes = [lower[a] + spacing * np.arange(shape[a]) for a in range(3)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).astype(np.float32)


class _Body:
    """A closed body that answers closest-point queries. vertices [m] and outward triangles: its surface."""

    def __init__(self, vertices: NDArray[np.float64], triangles: NDArray[np.int32]) -> None:
        points: wp.array = wp.array(vertices, dtype=wp.vec3f, device="cpu")
        indices: wp.array = wp.array(triangles.ravel(), dtype=wp.int32, device="cpu")
        self._mesh = wp.Mesh(points, indices, support_winding_number=True)
        self._lower, self._upper = vertices.min(axis=0), vertices.max(axis=0)

    def lower_distances(self, points: NDArray[np.float32], distance: NDArray[np.float32]) -> None:
        """Puts the signed distance of points (n, 3) to this body where it is less than `distance` (n,)."""
        outside = np.maximum(np.maximum(self._lower - points, points - self._upper), 0.0)
        near = np.flatnonzero(np.linalg.norm(outside, axis=1) <= np.maximum(distance, 0.0))  # else farther than its box
        at: wp.array = wp.array(points[near], dtype=wp.vec3f, device="cpu")
        out: wp.array = wp.array(distance[near], dtype=wp.float32, device="cpu")
        wp.launch(mesh_distance_kernel(), len(near), [self._mesh.id, at, FAR], [out], device="cpu")
        distance[near] = out.numpy()


def _union_distance(
    bodies: list[_Body], points: NDArray[np.float32], progress: Progress = silent, done: float = 0.0
) -> NDArray[np.float32]:
    """Least signed distance (n,) [m] of points (n, 3), FAR at most. done: share of the work before this level."""
    result = np.full(len(points), FAR, dtype=np.float32)
    for start in range(0, len(points), _CHUNK):
        progress(STAGE, done + start / len(points) / (REFINEMENTS + 1))
        part = slice(start, start + _CHUNK)
        for body in bodies:
            body.lower_distances(points[part], result[part])
    return result
