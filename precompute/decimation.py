"""Fewer triangles where a surface is flat, by edge collapses in the order of their quadric error.

Garland and Heckbert (1997), "Surface simplification using quadric error metrics": each vertex carries the
sum of squared distances to the planes of the triangles around it; an edge whose merged quadric stays smallest
is collapsed first. Here whole rounds of edges that share no neighbour are collapsed at once, which keeps the
work in array operations.
"""

import numpy as np
from numpy.typing import NDArray

_ROUNDS = 300


def decimate(
    vertices: NDArray[np.float64], triangles: NDArray[np.integer], triangle_count: int
) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """The closed surface with about `triangle_count` triangles, not fewer; vertices (n, 3), same orientation.

    A collapse that would make the surface non-manifold or fold a triangle over is left out.
    """
    vertices, faces = vertices.copy(), triangles.astype(np.int64)
    quadrics = _quadrics(vertices, faces)
    reluctance = np.ones(len(vertices))  # grows at vertices whose collapse was refused
    for _ in range(_ROUNDS):
        excess = (len(faces) - triangle_count) // 2
        if excess <= 0:
            break
        edges, cost, target = _candidates(vertices, faces, quadrics)
        cost = cost * reluctance[edges].max(axis=1)
        chosen = _independent(edges, cost, faces, len(vertices))
        chosen = chosen[np.argsort(cost[chosen])][: max(1, min(excess, len(edges) // 10))]
        safe = _safe(edges[chosen], target[chosen], vertices, faces)
        reluctance[edges[chosen[~safe]]] *= 10.0
        chosen = chosen[safe]
        keep, drop = edges[chosen].T
        vertices[keep] = target[chosen]
        quadrics[keep] += quadrics[drop]
        mapping = np.arange(len(vertices))
        mapping[drop] = keep
        faces = mapping[faces]
        repeats = (faces == np.roll(faces, 1, axis=1)).any(axis=1)
        faces = faces[~repeats]
    used, compact = np.unique(faces, return_inverse=True)
    return vertices[used], compact.reshape(-1, 3).astype(np.int32)


def _planes(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    """Area-weighted plane (n, -n.a) of every triangle, (m, 4)."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a) / 2.0
    root = np.sqrt(np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30))
    normal = normal / root  # length sqrt(area)
    return np.concatenate([normal, -(normal * a).sum(axis=1, keepdims=True)], axis=1)


def _quadrics(vertices: NDArray[np.float64], triangles: NDArray[np.int64]) -> NDArray[np.float64]:
    """Sum of plane products around every vertex, (n, 4, 4)."""
    planes = _planes(vertices, triangles)
    products = planes[:, :, None] * planes[:, None, :]
    out = np.zeros((len(vertices), 4, 4))
    for corner in range(3):
        np.add.at(out, triangles[:, corner], products)
    return out


def _candidates(
    vertices: NDArray[np.float64], triangles: NDArray[np.int64], quadrics: NDArray[np.float64]
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64]]:
    """Edges (k, 2), the error of collapsing each, (k,), and where the merged vertex would go, (k, 3)."""
    edges = np.unique(np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    merged = quadrics[edges[:, 0]] + quadrics[edges[:, 1]]
    a, b = vertices[edges[:, 0]], vertices[edges[:, 1]]
    middle = (a + b) / 2.0
    length2 = ((a - b) ** 2).sum(axis=1)
    # Minimum of the quadric, held near the middle by a small isotropic term, which also keeps triangles even.
    system = merged[:, :3, :3] + 1e-3 * np.trace(merged[:, :3, :3], axis1=1, axis2=2)[:, None, None] * np.eye(
        3
    )
    shift = np.linalg.solve(system, -(merged[:, :3, :3] @ middle[:, :, None] + merged[:, :3, 3:]))[:, :, 0]
    reach = np.sqrt(length2) / np.maximum(np.linalg.norm(shift, axis=1), 1e-12)
    target = middle + shift * np.minimum(1.0, 0.6 * reach)[:, None]
    homogeneous = np.concatenate([target, np.ones((len(target), 1))], axis=1)
    cost = np.einsum("ki,kij,kj->k", homogeneous, merged, homogeneous)
    return edges, cost + 1e-3 * length2 * np.sqrt(length2 * length2.mean()), target


def _independent(
    edges: NDArray[np.int64], cost: NDArray[np.float64], triangles: NDArray[np.int64], vertex_count: int
) -> NDArray[np.int64]:
    """Indices of edges that are the cheapest of all those within one triangle of their ends."""
    rank = np.empty(len(edges))
    rank[np.argsort(cost, kind="stable")] = np.arange(len(edges))
    lowest = np.full(vertex_count, np.inf)
    for end in range(2):
        np.minimum.at(lowest, edges[:, end], rank)
    for _ in range(2):  # spread over two rings: collapses of one round then touch separate triangles
        ring = lowest[triangles].min(axis=1)
        for corner in range(3):
            np.minimum.at(lowest, triangles[:, corner], ring)
    return np.flatnonzero((lowest[edges[:, 0]] == rank) & (lowest[edges[:, 1]] == rank))


def _safe(
    edges: NDArray[np.int64],
    target: NDArray[np.float64],
    vertices: NDArray[np.float64],
    triangles: NDArray[np.int64],
) -> NDArray[np.bool_]:
    """Which collapses keep the surface manifold (two shared neighbours) and fold nothing over, (k,)."""
    around: dict[int, list[int]] = {}
    wanted = np.zeros(len(vertices), dtype=bool)
    wanted[edges] = True
    near = np.flatnonzero(wanted[triangles].any(axis=1))
    for t in near.tolist():
        for v in triangles[t].tolist():
            if wanted[v]:
                around.setdefault(v, []).append(t)
    safe = np.zeros(len(edges), dtype=bool)
    for i, (a, b) in enumerate(edges.tolist()):
        ring_a = set(triangles[around[a]].ravel().tolist()) - {a}
        ring_b = set(triangles[around[b]].ravel().tolist()) - {b}
        if len(ring_a & ring_b) != 2 or len(ring_a | ring_b) < 6:
            continue
        faces = triangles[list(set(around[a]) ^ set(around[b]))]
        before = vertices[faces]
        after = before.copy()
        after[(faces == a) | (faces == b)] = target[i]
        old = np.cross(before[:, 1] - before[:, 0], before[:, 2] - before[:, 0])
        new = np.cross(after[:, 1] - after[:, 0], after[:, 2] - after[:, 0])
        length = np.linalg.norm(old, axis=1) * np.linalg.norm(new, axis=1)
        safe[i] = bool(((old * new).sum(axis=1) > 0.5 * length).all())
    return safe
