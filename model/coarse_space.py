"""A coarse space for elastic problems on a mesh: trilinear functions on a box grid around the nodes.

Z = W (x) I_3 with the trilinear weights W of every node; smooth motions, which a local preconditioner
hardly sees, are nearly in its span. Vertices that no free node has a share in are left out.
"""

from itertools import product

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

NODES_OF_VERTEX = 20
"""About as many nodes as there are for each vertex of the grid: some 500 vertices for 10,000 nodes."""
REGULARISATION = 1e-8
"""Relative growth of the coarse matrix's diagonal: functions that few nodes have a share in may be nearly dependent."""


def cell_count(node_count: int) -> int:
    """Boxes along the longest side that suit a mesh."""
    return max(1, round((node_count / NODES_OF_VERTEX) ** (1.0 / 3.0)))


def trilinear_weights(points: NDArray[np.float64], cells: int) -> sp.csr_array:
    """W, (points, vertices), for `cells` boxes along the longest side.

    Rows are non-negative and sum to one; every column has a share of some point.
    """
    low = points.min(axis=0)
    extent = np.ptp(points, axis=0)
    count = np.maximum(1, np.round(cells * extent / extent.max())).astype(np.int64)
    scaled = (points - low) / (extent / count + 1e-300)
    cell = np.clip(scaled.astype(np.int64), 0, count - 1)
    inside = scaled - cell
    rows, columns, weights = [], [], []
    for corner in product((0, 1), repeat=3):
        share = np.prod(np.where(corner, inside, 1.0 - inside), axis=1)
        vertex = cell + corner
        rows.append(np.arange(len(points)))
        columns.append(np.ravel_multi_index(tuple(vertex.T), tuple(count + 1)))
        weights.append(share)
    shape = (len(points), int(np.prod(count + 1)))
    entries = (np.concatenate(weights), (np.concatenate(rows), np.concatenate(columns)))
    W = sp.csr_array(sp.coo_array(entries, shape=shape))
    W.eliminate_zeros()
    used = np.unique(W.indices)
    return sp.csr_array(W[:, used])


def coarse_matrix(A: sp.bsr_array, W: sp.csr_array) -> NDArray[np.float64]:
    """Z^T A Z, (3 vertices, 3 vertices), dense."""
    Z = sp.csr_array(sp.kron(W, sp.eye_array(3), format="csr"))
    return (Z.T @ (A.tocsr() @ Z)).toarray()


def coarse_inverse(A: sp.bsr_array, W: sp.csr_array) -> NDArray[np.float64]:
    """The inverse of the slightly regularised coarse matrix, exactly symmetric."""
    matrix = coarse_matrix(A, W)
    diagonal = np.einsum("ii->i", matrix)
    diagonal *= 1.0 + REGULARISATION
    inverse = np.linalg.inv(matrix)
    return 0.5 * (inverse + inverse.T)
