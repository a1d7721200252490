"""A tetrahedral mesh as its file has it, and the TetMesh of it, with messages in the file's numbers."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from ...model.errors import LingualError
from ...model.tet_mesh import TetMesh, signed_volumes
from .warning import warn


@dataclass(frozen=True, eq=False)
class RawTetMesh:
    """Arrays in the file's unit and axes, not checked.

    nodes: (node_count, 3) float64; tets: (tet_count, 4) int64, indices from 0. source: the file, for
    messages. first_node, first_element: what the file numbers its first node and element.
    """

    nodes: NDArray[np.float64]
    tets: NDArray[np.int64]
    source: str
    first_node: int = 0
    first_element: int = 0


def checked_mesh(raw: RawTetMesh, nodes: NDArray[np.float64]) -> tuple[TetMesh, NDArray[np.int64]]:
    """The mesh with its nodes moved to `nodes` (node_count, 3) [m], head frame.

    When all elements are inverted (the file orders corners the other way round) they are turned. Nodes
    of no element are left out. Both are told by a MeshWarning.
    Returns the mesh and, for each of its nodes, the index in the file from 0, (kept_count,).

    Raises LingualError, naming element and node as the file numbers them, for a node that is not finite,
    an index out of range, or an inverted, flat or duplicated element.
    """
    tets = raw.tets
    _check_indices(raw)
    _check_duplicates(raw)
    volumes = signed_volumes(nodes, tets)
    if (volumes < 0.0).all():
        tets = tets[:, [0, 2, 1, 3]]
        volumes = -volumes
        warn(raw.source, "its elements list their corners in the opposite order; they are turned.")
    _check_volumes(raw, nodes, volumes)
    used = np.unique(tets)
    if len(used) < len(nodes):
        warn(raw.source, f"{len(nodes) - len(used)} nodes belong to no element and are left out.")
    return TetMesh(nodes[used], np.searchsorted(used, tets).astype(np.int32)), used


def check_attached(mesh: TetMesh, fixed_nodes: NDArray[np.integer], source: str) -> None:
    """Raises LingualError when a part of the mesh is connected to no fixed node: nothing would hold it."""
    edges = mesh.tets[:, [[0, 1], [0, 2], [0, 3]]].reshape(-1, 2)
    graph = coo_array((np.ones(len(edges)), edges.T), shape=(mesh.node_count, mesh.node_count))
    count, piece = connected_components(graph, directed=False)
    loose = np.setdiff1d(np.arange(count), piece[fixed_nodes])
    if len(loose):
        size = int((piece == loose[0]).sum())
        raise LingualError(
            f"{source}: the mesh falls into {count} pieces, and one of {size} nodes has no fixed node; "
            "join the pieces, remove the loose one or fix some of its nodes."
        )


def _check_indices(raw: RawTetMesh) -> None:
    if len(raw.nodes) < 4 or len(raw.tets) < 1:
        raise LingualError(
            f"{raw.source} has {len(raw.nodes)} nodes and {len(raw.tets)} tetrahedra: it cannot be used."
        )
    bad = np.flatnonzero(~np.isfinite(raw.nodes).all(axis=1))
    if len(bad):
        raise LingualError(
            f"{raw.source}: node {bad[0] + raw.first_node} has a coordinate that is not a finite number."
        )
    bad = np.flatnonzero((raw.tets < 0).any(axis=1) | (raw.tets >= len(raw.nodes)).any(axis=1))
    if len(bad):
        corners = raw.tets[bad[0]]
        node = corners[(corners < 0) | (corners >= len(raw.nodes))][0] + raw.first_node
        last = len(raw.nodes) - 1 + raw.first_node
        raise LingualError(
            f"{raw.source}: element {bad[0] + raw.first_element} names node {node}, but the nodes are "
            f"{raw.first_node} to {last}; nodes and elements do not belong together."
        )


def _check_duplicates(raw: RawTetMesh) -> None:
    keys = np.sort(raw.tets, axis=1)
    _, first, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    if len(first) < len(keys):
        repeat = np.setdiff1d(np.arange(len(keys)), first)[0]
        original = first[inverse.ravel()[repeat]]
        raise LingualError(
            f"{raw.source}: element {repeat + raw.first_element} repeats element "
            f"{original + raw.first_element}; remove one of them."
        )


def _check_volumes(raw: RawTetMesh, nodes: NDArray[np.float64], volumes: NDArray[np.float64]) -> None:
    bad = np.flatnonzero(volumes <= 1e-12 * np.ptp(nodes, axis=0).max() ** 3)  # TetMesh's own limit
    if len(bad):
        kind = "inverted" if volumes[bad[0]] < 0.0 else "flat"
        others = f", and {len(bad) - 1} others are" if len(bad) > 1 else ""
        raise LingualError(
            f"{raw.source}: element {bad[0] + raw.first_element} is {kind} (signed volume "
            f"{volumes[bad[0]] * 1e9:.3g} mm^3){others}; repair or re-tetrahedralise the mesh."
        )
