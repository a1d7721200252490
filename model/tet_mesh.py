"""Tetrahedral mesh of the tongue at rest, and the quantities that depend on its geometry alone."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .errors import LingualError
from .units import MM_PER_M

# The four faces of a positively oriented tetrahedron, each counter-clockwise seen from outside.
_FACES = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]])


@dataclass(frozen=True, eq=False)
class TetMesh:
    """Linear tetrahedra.

    nodes: rest positions [m], (node_count, 3) float64, jaw frame.
    tets: node indices, (tet_count, 4) int32, positively oriented
        (det[x1 - x0, x2 - x0, x3 - x0] > 0).

    Raises LingualError, naming the element, for an index out of range, an inverted, flat or
    duplicated element, or a node with a coordinate that is not finite.
    """

    nodes: NDArray[np.float64]
    tets: NDArray[np.int32]

    def __post_init__(self) -> None:
        object.__setattr__(self, "nodes", np.ascontiguousarray(self.nodes, dtype=np.float64))
        object.__setattr__(self, "tets", np.ascontiguousarray(self.tets, dtype=np.int32))
        _check(self.nodes, self.tets)

    @property
    def node_count(self) -> int:
        return len(self.nodes)

    @property
    def tet_count(self) -> int:
        return len(self.tets)

    @cached_property
    def volumes(self) -> NDArray[np.float64]:
        """Rest volume of each tetrahedron [m^3], (tet_count,)."""
        return signed_volumes(self.nodes, self.tets)

    @cached_property
    def volume(self) -> float:
        """Rest volume of the whole mesh [m^3]."""
        return float(self.volumes.sum())

    @cached_property
    def shape_gradients(self) -> NDArray[np.float64]:
        """Gradients of the four linear shape functions [1/m], (tet_count, 4, 3)."""
        x = self.nodes[self.tets]
        edges = x[:, 1:] - x[:, :1]  # rows are edge vectors: (tet_count, 3, 3)
        gradients = np.empty((self.tet_count, 4, 3))
        gradients[:, 1:] = np.linalg.inv(edges).transpose(0, 2, 1)
        gradients[:, 0] = -gradients[:, 1:].sum(axis=1)
        return gradients

    @cached_property
    def node_volumes(self) -> NDArray[np.float64]:
        """Volume lumped to each node, a quarter of every adjacent tetrahedron [m^3], (node_count,)."""
        quarter = np.repeat(self.volumes / 4.0, 4)
        return np.bincount(self.tets.ravel(), weights=quarter, minlength=self.node_count).astype(np.float64)

    @cached_property
    def boundary_triangles(self) -> NDArray[np.int32]:
        """Faces that belong to one tetrahedron only, outward, (triangle_count, 3)."""
        faces = self.tets[:, _FACES].reshape(-1, 3)
        _, first, counts = np.unique(np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True)
        return faces[np.sort(first[counts == 1])]

    @cached_property
    def boundary_nodes(self) -> NDArray[np.int64]:
        """Sorted indices of the nodes on the surface."""
        return np.unique(self.boundary_triangles).astype(np.int64)

    @cached_property
    def boundary_areas(self) -> NDArray[np.float64]:
        """Area lumped to each node, a third of every adjacent boundary triangle [m^2], (node_count,)."""
        triangles = self.boundary_triangles
        a, b, c = (self.nodes[triangles[:, i]] for i in range(3))
        third = np.repeat(np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6.0, 3)
        return np.bincount(triangles.ravel(), weights=third, minlength=self.node_count).astype(np.float64)


def signed_volumes(nodes: NDArray[np.float64], tets: NDArray[np.integer]) -> NDArray[np.float64]:
    """Signed volume of each tetrahedron, (tet_count,), in the cube of the nodes' unit."""
    x = nodes[tets]
    edges = x[:, 1:] - x[:, :1]
    return np.einsum("ei,ei->e", np.cross(edges[:, 0], edges[:, 1]), edges[:, 2]) / 6.0


def _check(nodes: NDArray[np.float64], tets: NDArray[np.int32]) -> None:
    if nodes.ndim != 2 or nodes.shape[1] != 3 or len(nodes) < 4:
        raise LingualError(f"The mesh has node coordinates of shape {nodes.shape}; (4 or more, 3) is needed.")
    if tets.ndim != 2 or tets.shape[1] != 4 or len(tets) < 1:
        raise LingualError(f"The mesh has elements of shape {tets.shape}; tetrahedra (1 or more, 4) are needed.")
    bad_nodes = np.flatnonzero(~np.isfinite(nodes).all(axis=1))
    if len(bad_nodes):
        raise LingualError(f"Mesh node {bad_nodes[0]} has a coordinate that is not a finite number.")
    out_of_range = np.flatnonzero((tets < 0).any(axis=1) | (tets >= len(nodes)).any(axis=1))
    if len(out_of_range):
        e = out_of_range[0]
        raise LingualError(
            f"Mesh element {e} names node {tets[e].max() if tets[e].max() >= len(nodes) else tets[e].min()}, "
            f"but the nodes are 0 to {len(nodes) - 1}: the node and element files do not belong together."
        )
    _, first, inverse = np.unique(np.sort(tets, axis=1), axis=0, return_index=True, return_inverse=True)
    if len(first) < len(tets):
        duplicate = np.setdiff1d(np.arange(len(tets)), first)[0]
        original = first[inverse.ravel()[duplicate]]
        raise LingualError(f"Mesh element {duplicate} repeats element {original}: remove one of them.")
    volumes = signed_volumes(nodes, tets)
    bad = np.flatnonzero(volumes <= 1e-12 * np.ptp(nodes, axis=0).max() ** 3)
    if len(bad):
        kind = "inverted" if volumes[bad[0]] < 0 else "flat"
        raise LingualError(
            f"Mesh element {bad[0]} is {kind} (signed volume {volumes[bad[0]] * MM_PER_M**3:.3g} mm^3; "
            f"{len(bad)} such elements): repair or re-tetrahedralise the mesh."
        )
