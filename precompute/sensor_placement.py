"""Articulograph coils on the midline of a tongue's upper surface, at given distances behind the tip.

The boundary is cut by the midsagittal plane y = `midline`; from the most anterior point of the section the
upper branch is followed backwards and its length measured. A coil follows the weighted mean of the surface
nodes under it: the weights are the smallest non-negative ones that sum to one and put the mean on the coil.
"""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.optimize import nnls

from ..model.errors import LingualError
from ..model.sensors import SENSOR_NAMES, SensorLayout
from ..model.tet_mesh import TetMesh

ARC_LENGTHS = (0.010, 0.030, 0.045, 0.060)
"""Distances of TT, TB, TD and TR behind the tip along the surface [m], as in Luo (2017)."""

FOOTPRINT_RADIUS = 0.00175
"""Radius of the patch of surface that a coil holds [m]: coils are 3 to 4 mm across with their glue."""


def sensors_on_midline(
    mesh: TetMesh,
    arc_lengths: tuple[float, ...] = ARC_LENGTHS,
    names: tuple[str, ...] = SENSOR_NAMES,
    midline: float | None = None,
) -> SensorLayout:
    """Coils at `arc_lengths` [m] behind the tip; the mesh is in the head frame (x anterior, z up).

    midline: y of the plane of symmetry [m]; the middle of the mesh's lateral extent when None.

    Raises LingualError when the upper surface is shorter than the last distance.
    """
    line = upper_midline(mesh, midline)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    if length[-1] < max(arc_lengths):
        raise LingualError(
            f"The tongue's upper surface is {length[-1] * 1e3:.0f} mm long from tip to root, too short for a "
            f"sensor {max(arc_lengths) * 1e3:.0f} mm behind the tip: check the mesh's unit and axes."
        )
    points = np.stack([np.interp(arc_lengths, length, line[:, axis]) for axis in range(3)], axis=1)
    return sensors_at(mesh, points, names)


def sensors_at(mesh: TetMesh, points: NDArray[np.floating], names: tuple[str, ...]) -> SensorLayout:
    """Coils at the surface points nearest to `points` (sensor_count, 3) [m], frame of the mesh."""
    rows = [_footprint_weights(mesh, np.asarray(point, dtype=np.float64)) for point in points]
    indices = np.concatenate([nodes for nodes, _ in rows])
    indptr = np.concatenate([[0], np.cumsum([len(nodes) for nodes, _ in rows])])
    data = np.concatenate([weights for _, weights in rows])
    return SensorLayout(names, sp.csr_array((data, indices, indptr), shape=(len(rows), mesh.node_count)))


def upper_midline(mesh: TetMesh, midline: float | None = None) -> NDArray[np.float64]:
    """Section of the upper surface by the plane y = midline, from the tip backwards, (n, 3) [m].

    It ends where the outline turns forward again below the root: at its most posterior-inferior point.
    """
    y = float(mesh.nodes[:, 1].min() + mesh.nodes[:, 1].max()) / 2.0 if midline is None else midline
    loop = _section(mesh, y)
    loop = np.roll(loop, -int(np.argmax(loop[:, 0])), axis=0)
    forth = np.concatenate([loop, loop[:1]])
    back = forth[::-1]
    line = forth if _mean_height(forth) > _mean_height(back) else back
    behind = (line[:, 2] - line[:, 2].min()) + (line[:, 0] - line[:, 0].min())
    return line[: int(np.argmin(behind)) + 1]


def _section(mesh: TetMesh, y: float) -> NDArray[np.float64]:
    """Longest closed outline of the boundary in the plane y, (n, 3), as points in order."""
    triangles = mesh.boundary_triangles
    height = mesh.nodes[:, 1] - y
    height[height == 0.0] = 1e-9 * np.ptp(mesh.nodes[:, 1])  # no node lies in the plane
    above = height[triangles] > 0.0
    cut = triangles[above.any(axis=1) & ~above.all(axis=1)]
    if len(cut) == 0:
        raise LingualError(f"The plane y = {y * 1e3:.1f} mm does not cut the tongue: give its midline.")
    edges = np.sort(cut[:, [[0, 1], [1, 2], [2, 0]]], axis=2)
    crossing = (height[edges] > 0.0).sum(axis=2) == 1
    unique, ids = np.unique(edges[crossing], axis=0, return_inverse=True)
    segments = ids.reshape(-1, 2)
    a, b = unique[:, 0], unique[:, 1]
    t = (height[a] / (height[a] - height[b]))[:, None]
    points = (1.0 - t) * mesh.nodes[a] + t * mesh.nodes[b]
    loops = [points[chain] for chain in _chains(segments)]
    return max(loops, key=lambda p: float(np.linalg.norm(np.diff(p, axis=0), axis=1).sum()))


def _chains(segments: NDArray[np.integer]) -> list[list[int]]:
    """Closed chains of point indices; every point belongs to two segments."""
    neighbours: dict[int, list[int]] = {}
    for a, b in segments.tolist():
        neighbours.setdefault(a, []).append(b)
        neighbours.setdefault(b, []).append(a)
    chains = []
    while neighbours:
        start = current = next(iter(neighbours))
        chain = [start]
        while True:
            following = neighbours.pop(current)
            current = next((n for n in following if n in neighbours), -1)
            if current < 0:
                break
            chain.append(current)
        chains.append(chain)
    return chains


def _mean_height(line: NDArray[np.float64], reach: float = 0.03) -> float:
    """Mean z of the first `reach` metres of a polyline."""
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    return float(np.interp(np.linspace(0.0, reach, 20), length, line[:, 2]).mean())


def _footprint_weights(
    mesh: TetMesh, point: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Surface nodes under a coil and their weights: (k,), (k,), k >= 3."""
    triangle, snapped = _nearest(mesh, point)
    surface = mesh.boundary_nodes
    distance = np.linalg.norm(mesh.nodes[surface] - snapped, axis=1)
    nodes = np.union1d(surface[distance < FOOTPRINT_RADIUS], triangle)
    # Rows: sum of weights, weighted mean (both imposed by a large factor), smallness and evenness.
    offset = (mesh.nodes[nodes] - snapped) / FOOTPRINT_RADIUS
    count = len(nodes)
    matrix = np.concatenate([1e4 * np.ones((1, count)), 1e4 * offset.T, np.eye(count)])
    target = np.concatenate([[1e4], np.zeros(3), np.zeros(count)])
    weights, _ = nnls(matrix, target)
    return nodes, weights / weights.sum()


def _nearest(mesh: TetMesh, point: NDArray[np.float64]) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Boundary triangle (3,) nearest to a point, and the nearest point on it (3,)."""
    triangles = mesh.boundary_triangles
    corners = mesh.nodes[triangles]
    spread = np.linalg.norm(corners - corners.mean(axis=1, keepdims=True), axis=2).max(axis=1)
    distance = np.linalg.norm(corners.mean(axis=1) - point, axis=1)
    candidates = np.flatnonzero(distance - spread <= (distance + spread).min())
    closest = [_closest_on_triangle(corners[i], point) for i in candidates]
    best = int(np.argmin([np.linalg.norm(c - point) for c in closest]))
    return triangles[candidates[best]], closest[best]


def _closest_on_triangle(corners: NDArray[np.float64], point: NDArray[np.float64]) -> NDArray[np.float64]:
    """Point of a triangle (3, 3) nearest to `point`."""
    a, ab, ac = corners[0], corners[1] - corners[0], corners[2] - corners[0]
    inner, *_ = np.linalg.lstsq(np.stack([ab, ac], axis=1), point - a, rcond=None)
    if inner.min() >= 0.0 and inner.sum() <= 1.0:
        return a + inner[0] * ab + inner[1] * ac
    best = a
    for start, end in ((0, 1), (1, 2), (2, 0)):
        edge = corners[end] - corners[start]
        t = np.clip((point - corners[start]) @ edge / max(float(edge @ edge), 1e-30), 0.0, 1.0)
        candidate = corners[start] + t * edge
        if np.linalg.norm(candidate - point) < np.linalg.norm(best - point):
            best = candidate
    return best
