"""Where a plane meets the tetrahedra: the inside of the tongue, for the midsagittal cut."""

import numpy as np
from numpy.typing import NDArray


def _edges_by_case() -> list[NDArray[np.int64]]:
    """For each set of far corners (a bit mask): the crossed edges of its triangles, (triangles, 3, 2)."""
    cases = []
    for mask in range(16):
        far = [i for i in range(4) if mask >> i & 1]
        near = [i for i in range(4) if i not in far]
        if len(far) == 2:
            (i, j), (k, l) = far, near
            corners = [[(i, k), (i, l), (j, l)], [(i, k), (j, l), (j, k)]]
        elif far and near:
            corners = [[(i, j) for i in far for j in near]]
        else:
            corners = []
        cases.append(np.array(corners, dtype=np.int64).reshape(-1, 3, 2))
    return cases


_CASES = _edges_by_case()


def cross_section(
    tets: NDArray[np.integer], height: NDArray[np.floating]
) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Triangles of the surface height = 0 inside the tetrahedra, as interpolation between nodes.

    tets: (tet_count, 4). height: signed distance of every node from the plane, (node_count,).
    Returns nodes (corner_count, 2) and the weight of the second of them (corner_count,); three corners
    in a row make a triangle, of either orientation.
    """
    far = height > 0.0
    case = far[tets] @ np.array([1, 2, 4, 8])
    pairs = [np.zeros((0, 2), dtype=np.int64)]
    for mask in range(1, 15):
        found = tets[case == mask]
        if len(found):
            pairs.append(found[:, _CASES[mask]].reshape(-1, 2))
    nodes = np.concatenate(pairs)
    first, second = height[nodes[:, 0]], height[nodes[:, 1]]
    return nodes, (first / (first - second)).astype(np.float32)
