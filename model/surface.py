"""Triangle surfaces: the display surface that follows the mesh, and the rigid parts of the mouth."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray


def vertex_normal_operator(vertex_count: int, triangles: NDArray[np.integer]) -> sp.csr_array:
    """Sparse (vertex_count, triangle_count) incidence: sums area-weighted face normals at vertices."""
    faces = np.repeat(np.arange(len(triangles)), 3)
    ones = np.ones(len(faces), dtype=np.float32)
    return sp.csr_array((ones, (triangles.ravel(), faces)), shape=(vertex_count, len(triangles)))


def vertex_normals(
    vertices: NDArray[np.floating], triangles: NDArray[np.integer], operator: sp.csr_array
) -> NDArray[np.float32]:
    """Unit normals (vertex_count, 3), area-weighted; zero where the surface has no area."""
    v = vertices.astype(np.float32, copy=False)
    a, b, c = v[triangles[:, 0]], v[triangles[:, 1]], v[triangles[:, 2]]
    normals = operator @ np.cross(b - a, c - a)
    length = np.linalg.norm(normals, axis=1, keepdims=True)
    return normals / np.maximum(length, 1e-30)


@dataclass(frozen=True, eq=False)
class EmbeddedSurface:
    """A triangle surface carried by the tetrahedral mesh (skin).

    triangles: (triangle_count, 3) int32, outward.
    weights: (vertex_count, node_count) sparse, rows sum to one: vertex = weights @ nodes.
        The boundary of the mesh itself is the identity on the boundary nodes.
    """

    triangles: NDArray[np.int32]
    weights: sp.csr_array

    @property
    def vertex_count(self) -> int:
        return self.weights.shape[0]

    @cached_property
    def _normal_operator(self) -> sp.csr_array:
        return vertex_normal_operator(self.vertex_count, self.triangles)

    def vertices(self, nodes: NDArray[np.floating]) -> NDArray[np.floating]:
        """Vertex positions (vertex_count, 3) for node positions (node_count, 3)."""
        return self.weights @ nodes

    def normals(self, vertices: NDArray[np.floating]) -> NDArray[np.float32]:
        """Unit vertex normals (vertex_count, 3) of deformed vertices."""
        return vertex_normals(vertices, self.triangles, self._normal_operator)


@dataclass(frozen=True, eq=False)
class RigidSurface:
    """A rigid part of the mouth.

    name: e.g. "mandible", "lower_teeth", "palate", "upper_teeth", "hyoid".
    tissue: what it looks like: "bone", "tooth" or "mucosa".
    frame: "jaw" (moves with the mandible) or "head".
    vertices: (vertex_count, 3) float64 [m], in that frame; triangles: (triangle_count, 3) int32, outward.
    """

    name: str
    tissue: str
    frame: str
    vertices: NDArray[np.float64]
    triangles: NDArray[np.int32]

    @cached_property
    def normals(self) -> NDArray[np.float32]:
        """Unit vertex normals, (vertex_count, 3)."""
        operator = vertex_normal_operator(len(self.vertices), self.triangles)
        return vertex_normals(self.vertices, self.triangles, operator)
