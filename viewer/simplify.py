"""Fewer triangles for slow renderers, by edge collapse with quadric errors.

Garland and Heckbert (1997) with two restrictions: a vertex collapses onto a neighbour, so that the
result uses a subset of the original vertices (with their normals, weights and shading), and in each
round every vertex that is the cheapest of its neighbourhood collapses at once, so that a round is a
few array operations.
"""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

_ROUNDS = 60
_MIN_COSINE = 0.25  # between a triangle's normal before and after a collapse


def simplified(
    vertices: NDArray[np.floating], triangles: NDArray[np.integer], target: int
) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """About `target` triangles that look the same: (kept vertex indices, triangles over the kept ones).

    vertices: (vertex_count, 3); triangles: (triangle_count, 3). Open borders stay as they are. With
    fewer triangles than `target` everything is kept.
    """
    points = np.asarray(vertices, dtype=np.float64)
    faces = np.asarray(triangles, dtype=np.int64)
    quadrics = _quadrics(points, faces)
    for _ in range(_ROUNDS):
        surplus = (len(faces) - target) // 2
        if surplus <= 0:
            break
        source, destination = _collapses(points, faces, quadrics, surplus)
        if not len(source):
            break
        onto = np.arange(len(points))
        onto[source] = destination
        np.add.at(quadrics, destination, quadrics[source])
        faces = onto[faces]
        distinct = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
        faces = faces[distinct]
    kept = np.unique(faces)
    index = np.zeros(len(points), dtype=np.int32)
    index[kept] = np.arange(len(kept))
    return kept, index[faces]


def _quadrics(points: NDArray[np.float64], faces: NDArray[np.int64]) -> NDArray[np.float64]:
    """Area-weighted squared distance to the planes around each vertex, (vertex_count, 4, 4)."""
    a, b, c = points[faces[:, 0]], points[faces[:, 1]], points[faces[:, 2]]
    normal = np.cross(b - a, c - a)
    area = np.linalg.norm(normal, axis=1, keepdims=True)
    normal /= np.maximum(area, 1e-30)
    plane = np.column_stack([normal, -np.einsum("ij,ij->i", normal, a)])
    per_face = area[:, :, None] * plane[:, :, None] * plane[:, None, :]
    of_face = np.repeat(np.arange(len(faces)), 3)
    incidence = sp.csr_array((np.ones(faces.size), (faces.ravel(), of_face)), shape=(len(points), len(faces)))
    return (incidence @ per_face.reshape(-1, 16)).reshape(-1, 4, 4)


def _collapses(
    points: NDArray[np.float64], faces: NDArray[np.int64], quadrics: NDArray[np.float64], limit: int
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Independent collapses of one round, cheapest first, at most `limit`: (from, onto)."""
    tail, head, shared = _edges(faces, len(points))
    at = np.column_stack([points[head], np.ones(len(head))])
    length = np.einsum("ij,ij->i", points[head] - points[tail], points[head] - points[tail])
    cost = np.einsum("ij,ijk,ik->i", at, quadrics[tail], at) + 1e-4 * length * length
    border = np.zeros(len(points), dtype=bool)
    border[tail[shared != 2]] = True  # also refuses to pinch the surface
    cost[border[tail] | (shared != 2)] = np.inf

    best = np.full(len(points), np.inf)
    np.minimum.at(best, tail, cost)
    least_around = best.copy()
    np.minimum.at(least_around, tail, best[head])
    chosen = np.flatnonzero(np.isfinite(cost) & (cost == best[tail]) & (best[tail] <= least_around[tail]))
    chosen = chosen[np.unique(tail[chosen], return_index=True)[1]]
    chosen = _without_folds(points, faces, tail, head, chosen)
    chosen = chosen[np.argsort(cost[chosen], kind="stable")][: max(min(limit, (len(chosen) * 4) // 5), 1)]
    return tail[chosen], head[chosen]


def _edges(faces: NDArray[np.int64], count: int) -> tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]:
    """Directed edges, each both ways (tail, head), and the number of neighbours that both ends share."""
    i = faces[:, [0, 1, 2, 1, 2, 0]].ravel()
    j = faces[:, [1, 2, 0, 0, 1, 2]].ravel()
    adjacency = sp.csr_array((np.ones(len(i), dtype=np.int32), (i, j)), shape=(count, count))
    adjacency.data[:] = 1
    common = (adjacency @ adjacency).multiply(adjacency).tocsr() + adjacency
    common.sum_duplicates()
    coo = common.tocoo()
    return coo.row.astype(np.int64), coo.col.astype(np.int64), coo.data.astype(np.int64) - 1


def _without_folds(
    points: NDArray[np.float64],
    faces: NDArray[np.int64],
    tail: NDArray[np.int64],
    head: NDArray[np.int64],
    chosen: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Drops the collapses that would turn a triangle over."""
    onto = np.arange(len(points))
    onto[tail[chosen]] = head[chosen]
    after = onto[faces]
    moved = (after != faces).any(axis=1)
    alive = (after[:, 0] != after[:, 1]) & (after[:, 1] != after[:, 2]) & (after[:, 2] != after[:, 0])
    rows = np.flatnonzero(moved & alive)
    before_normal, after_normal = _normals(points, faces[rows]), _normals(points, after[rows])
    cosine = np.einsum("ij,ij->i", before_normal, after_normal)
    size = np.linalg.norm(before_normal, axis=1) * np.linalg.norm(after_normal, axis=1)
    folded = rows[cosine <= _MIN_COSINE * size]
    bad = np.zeros(len(points), dtype=bool)
    bad[faces[folded][after[folded] != faces[folded]]] = True
    return chosen[~bad[tail[chosen]]]


def _normals(points: NDArray[np.float64], faces: NDArray[np.int64]) -> NDArray[np.float64]:
    a, b, c = points[faces[:, 0]], points[faces[:, 1]], points[faces[:, 2]]
    return np.cross(b - a, c - a)
