"""Which domain each node belongs to: flooding from all seeds at once (Luo 2017, section 7, Fig. 6).

The flood runs along the edges of the mesh at the same speed from every seed (Dijkstra's algorithm with edge lengths
as distances); a node belongs to the seed whose flood reaches it first. For display and reports: the
weights themselves overlap and do not use it.
"""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from ..model import TetMesh

_EDGES = np.array([[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]])


def flooded_partition(mesh: TetMesh, seed_nodes: list[NDArray[np.int64]]) -> NDArray[np.int64]:
    """Index of the domain of every node, (node_count,).

    seed_nodes: of each domain the nodes that its flood starts from, one at least; disjoint. A part of the mesh
    that no edge joins to a seed goes to the seed nearest in a straight line.
    """
    sources = np.concatenate(seed_nodes)
    domain_of_source = np.repeat(np.arange(len(seed_nodes)), [len(nodes) for nodes in seed_nodes])
    first_source = dijkstra(
        _edge_lengths(mesh), directed=False, indices=sources, min_only=True, return_predecessors=True
    )[2]
    domain_of_node = np.full(mesh.node_count, -1)
    domain_of_node[sources] = domain_of_source
    reached = first_source >= 0
    domain_of_node[reached] = domain_of_node[first_source[reached]]
    if not reached.all():
        nearest = cKDTree(mesh.nodes[sources]).query(mesh.nodes[~reached])[1]
        domain_of_node[~reached] = domain_of_source[nearest]
    return domain_of_node


def nearest_nodes(mesh: TetMesh, points: NDArray[np.float64]) -> list[NDArray[np.int64]]:
    """The node nearest to each point (count, 3) [m], to flood from where a seed's nodes are not at hand."""
    nearest = cKDTree(mesh.nodes).query(points)[1]
    return [np.array([node]) for node in nearest]


def _edge_lengths(mesh: TetMesh) -> sp.csr_array:
    """Length of every edge [m], (node_count, node_count), each edge once."""
    first, second = np.unique(np.sort(mesh.tets[:, _EDGES].reshape(-1, 2), axis=1), axis=0).T
    length = np.linalg.norm(mesh.nodes[first] - mesh.nodes[second], axis=1)
    return sp.csr_array((length, (first, second)), shape=(mesh.node_count, mesh.node_count))
