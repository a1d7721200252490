"""Display surface of a tongue: its boundary, Loop-subdivided, as sparse weights over the nodes.

Loop (1987), "Smooth subdivision surfaces based on triangles": a new vertex on an edge takes 3/8 of its ends
and 1/8 of the two opposite vertices, an old vertex keeps 1 - n beta of itself and takes beta of its n
neighbours. The last step moves every vertex to its position on the limit surface. Everything is linear in
the nodes, so the product of the steps' matrices carries the skin through any deformation.
"""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..model.surface import EmbeddedSurface
from ..model.tet_mesh import TetMesh

VERTEX_COUNT = 12_000
"""Vertices that the display surface has at least, unless two subdivisions do not get there."""


def skin_of(mesh: TetMesh, vertex_count: int = VERTEX_COUNT, smoothing_count: int = 1) -> EmbeddedSurface:
    """The smooth display surface of `mesh`.

    vertex_count: subdivided, once at least and twice at most, until the surface has half this many
        vertices. smoothing_count: rounds of Taubin smoothing of the boundary before that (they keep its
        volume), which take off the unevenness of the mesh.
    """
    surface = mesh.boundary_nodes
    local = np.full(mesh.node_count, -1, dtype=np.int64)
    local[surface] = np.arange(len(surface))
    triangles = local[mesh.boundary_triangles]
    weights: sp.csr_array = sp.csr_array(
        (np.ones(len(surface)), (np.arange(len(surface)), surface)), shape=(len(surface), mesh.node_count)
    )
    for _ in range(smoothing_count):
        for factor in (0.5, -0.53):
            weights = _umbrella(triangles, factor) @ weights
    for level in range(2):
        if level and weights.shape[0] > 0.5 * vertex_count:
            break
        step, triangles = _loop_step(triangles)
        weights = step @ weights
    weights = _limit(triangles) @ weights
    return EmbeddedSurface(triangles.astype(np.int32), _tidied(weights))


def _adjacency(triangles: NDArray[np.int64]) -> sp.csr_array:
    """(n, n) ones between vertices that share an edge."""
    count = int(triangles.max()) + 1
    a, b = triangles[:, [0, 1, 2]].ravel(), triangles[:, [1, 2, 0]].ravel()
    matrix = sp.csr_array((np.ones(2 * len(a)), (np.r_[a, b], np.r_[b, a])), shape=(count, count))
    matrix.data[:] = 1.0
    return matrix


def _umbrella(triangles: NDArray[np.int64], factor: float) -> sp.csr_array:
    """x + factor (mean of neighbours - x)."""
    adjacency = _adjacency(triangles)
    degree = adjacency.sum(axis=1)
    mean = sp.diags_array(1.0 / degree) @ adjacency
    return sp.csr_array((1.0 - factor) * sp.eye_array(len(degree)) + factor * mean)


def _loop_beta(degree: NDArray[np.float64]) -> NDArray[np.float64]:
    """Loop's weight of each of `degree` neighbours."""
    return (0.625 - (0.375 + 0.25 * np.cos(2.0 * np.pi / degree)) ** 2) / degree


def _loop_step(triangles: NDArray[np.int64]) -> tuple[sp.csr_array, NDArray[np.int64]]:
    """Matrix (new vertices, old vertices) and the four times as many triangles of one subdivision."""
    adjacency = _adjacency(triangles)
    count = adjacency.shape[0]
    degree = adjacency.sum(axis=1)
    beta = _loop_beta(degree)
    old = sp.diags_array(1.0 - degree * beta) + sp.diags_array(beta) @ adjacency

    halves = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    edges, edge_of, use = np.unique(halves, axis=0, return_inverse=True, return_counts=True)
    edge_of = edge_of.reshape(-1)
    opposite = triangles[:, [2, 0, 1]].reshape(-1)
    # 1/8 of each opposite vertex; an edge of a non-manifold mesh shares the same 1/4 among more of them.
    rows = np.r_[np.repeat(np.arange(len(edges)), 2), edge_of]
    columns = np.r_[edges.ravel(), opposite]
    values = np.r_[np.full(2 * len(edges), 0.375), 0.25 / use[edge_of]]
    new = sp.csr_array((values, (rows, columns)), shape=(len(edges), count))

    a, b, c = triangles.T
    ab, bc, ca = (count + edge_of.reshape(-1, 3)).T
    faces = np.stack(
        [np.stack(t, axis=1) for t in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))], axis=1
    )
    return sp.csr_array(sp.vstack([old, new])), faces.reshape(-1, 3)


def _limit(triangles: NDArray[np.int64]) -> sp.csr_array:
    """Matrix that moves vertices to the limit of endless subdivision."""
    adjacency = _adjacency(triangles)
    degree = adjacency.sum(axis=1)
    neighbour = 1.0 / (0.375 / _loop_beta(degree) + degree)
    return sp.csr_array(sp.diags_array(1.0 - degree * neighbour) + sp.diags_array(neighbour) @ adjacency)


def _tidied(weights: sp.csr_array) -> sp.csr_array:
    """Rows without weights below 1e-4, which cost time and do not show, summing to one again."""
    weights = sp.csr_array(weights)
    weights.data[np.abs(weights.data) < 1e-4] = 0.0
    weights.eliminate_zeros()
    weights = sp.csr_array(sp.diags_array(1.0 / weights.sum(axis=1)) @ weights)
    weights.sort_indices()
    return weights
