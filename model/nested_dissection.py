"""Elimination order of a mesh's nodes by geometric nested dissection (George 1973), and its symbolic factor.

The nodes are halved at the median of a coordinate; the fewest nodes that touch every edge between the halves
(a minimum vertex cover of the cut edges, by Koenig's theorem) separate them and are eliminated last. Of the
three coordinates the one with the smallest separator is taken. The halves are dissected likewise until
`LEAF_NODES` nodes remain. On tetrahedral meshes the factor has half the entries of one ordered by minimum degree,
and its dense fronts suit BLAS.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import maximum_bipartite_matching

LEAF_NODES = 60
"""Fewer give a smaller factor in more fronts, each of which costs some microseconds beside its arithmetic."""


@dataclass(frozen=True)
class Front:
    """Nodes that are eliminated together, and what their elimination couples.

    start, end: range of the elimination order. boundary: later nodes (places in that order, sorted) which the
    eliminated ones touch, directly or through their descendants. children: fronts whose elimination
    contributes to this one, always earlier in the list of fronts.
    """

    start: int
    end: int
    boundary: NDArray[np.int64]
    children: tuple[int, ...]


@dataclass(frozen=True)
class EliminationTree:
    """order: node eliminated at each place, (node_count,). fronts: children before parents, the root last."""

    order: NDArray[np.int64]
    fronts: tuple[Front, ...]


def dissect(
    points: NDArray[np.float64], row_starts: NDArray[np.integer], columns: NDArray[np.integer]
) -> EliminationTree:
    """The elimination of a matrix whose rows are nodes at `points` (n, 3), with a symmetric pattern of rows."""
    node_count = len(points)
    rows = np.repeat(np.arange(node_count), np.diff(row_starts))
    edges = np.stack([rows, columns], axis=1)[rows < columns]
    parts: list[tuple[NDArray[np.int64], tuple[int, ...]]] = []
    _dissect(np.arange(node_count), edges, points, np.zeros(node_count, dtype=np.int8), parts)
    order = np.concatenate([nodes for nodes, _ in parts])
    return EliminationTree(order, _fronts(parts, order, row_starts, columns))


def _dissect(
    nodes: NDArray[np.int64],
    edges: NDArray[np.int64],
    points: NDArray[np.float64],
    side: NDArray[np.int8],
    parts: list[tuple[NDArray[np.int64], tuple[int, ...]]],
) -> int:
    """Appends the parts of `nodes` in elimination order; the index of the last. `side` is workspace."""
    if len(nodes) <= LEAF_NODES:
        parts.append((nodes, ()))
        return len(parts) - 1
    best: tuple[NDArray[np.int64], NDArray[np.int8]] | None = None
    for axis in range(3):
        order = np.argsort(points[nodes, axis], kind="stable")
        side[nodes[order[: len(nodes) // 2]]] = 1
        side[nodes[order[len(nodes) // 2 :]]] = 2
        separator = _separator(edges, side)
        if best is None or len(separator) < len(best[0]):
            best = separator, side[nodes].copy()
    assert best is not None
    separator, side[nodes] = best
    side[separator] = 0
    of_edges = side[edges]
    halves = [(nodes[side[nodes] == half], edges[(of_edges == half).all(axis=1)]) for half in (1, 2)]
    children = tuple(_dissect(*half, points, side, parts) for half in halves if len(half[0]))
    parts.append((separator, children))
    return len(parts) - 1


def _separator(edges: NDArray[np.int64], side: NDArray[np.int8]) -> NDArray[np.int64]:
    """The fewest nodes that touch every edge from side 1 to side 2."""
    cut = edges[side[edges[:, 0]] != side[edges[:, 1]]]
    cut = np.where((side[cut[:, 0]] == 1)[:, None], cut, cut[:, ::-1])
    left, l = np.unique(cut[:, 0], return_inverse=True)
    right, r = np.unique(cut[:, 1], return_inverse=True)
    graph = sp.csr_array((np.ones(len(cut), dtype=np.int8), (l, r)), shape=(len(left), len(right)))
    partner = maximum_bipartite_matching(graph, perm_type="column")
    partner_of_right = np.full(len(right), -1)
    partner_of_right[partner[partner >= 0]] = np.flatnonzero(partner >= 0)
    reached_left, reached_right = partner < 0, np.zeros(len(right), dtype=bool)
    frontier = np.flatnonzero(reached_left)
    while len(frontier):  # alternating paths from the nodes without a partner
        found = np.unique(graph[frontier].indices)
        found = found[~reached_right[found]]
        reached_right[found] = True
        frontier = partner_of_right[found]
        frontier = frontier[(frontier >= 0) & ~reached_left[frontier]]
        reached_left[frontier] = True
    return np.concatenate([left[~reached_left], right[reached_right]])


def _fronts(
    parts: list[tuple[NDArray[np.int64], tuple[int, ...]]],
    order: NDArray[np.int64],
    row_starts: NDArray[np.integer],
    columns: NDArray[np.integer],
) -> tuple[Front, ...]:
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order))
    fronts: list[Front] = []
    start = 0
    for nodes, children in parts:
        end = start + len(nodes)
        touched = [place[columns[row_starts[n] : row_starts[n + 1]]] for n in nodes]
        touched += [fronts[child].boundary for child in children]
        boundary = np.unique(np.concatenate(touched)) if touched else np.zeros(0, dtype=np.int64)
        fronts.append(Front(start, end, boundary[boundary >= end], children))
        start = end
    return tuple(fronts)
