"""A tongue's vibration modes and the node rotations that belong to them (what modal warping runs on)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from .tet_mesh import TetMesh
from .tongue_model import TongueModel


@dataclass(frozen=True, eq=False)
class ModalModel:
    """The m lowest modes of the linearised tongue with its fixed nodes held (Yang 2013, section 4).

    tongue: whose modes they are.
    eigenvalues: squared angular frequencies, ascending [1/s^2], (mode_count,) float64.
    modes: Phi, (3 node_count, mode_count) float64 [1/sqrt(kg)], row 3 n + i; zero at fixed nodes.
        Mass-orthonormal: Phi^T M Phi = I for the lumped mass, Phi^T K Phi = diag(eigenvalues).

    Modal coordinates q have one component: (mode_count, 1, tongue_count) [m sqrt(kg)].
    """

    tongue: TongueModel
    eigenvalues: NDArray[np.float64]
    modes: NDArray[np.float64]

    @property
    def mode_count(self) -> int:
        return len(self.eigenvalues)

    @property
    def frequencies(self) -> NDArray[np.float64]:
        """Undamped natural frequencies [Hz], (mode_count,)."""
        return np.sqrt(self.eigenvalues) / (2.0 * np.pi)

    @property
    def damping(self) -> NDArray[np.float64]:
        """Diagonal of the modal Rayleigh damping matrix [1/s], (mode_count,): 2 zeta_i omega_i."""
        material = self.tongue.material
        return material.damping_mass + material.damping_stiffness * self.eigenvalues

    @cached_property
    def rotation_modes(self) -> NDArray[np.float64]:
        """Psi = W Phi, (3 node_count, mode_count): rotation vectors of the nodes [rad] = Psi @ q."""
        return nodal_curl(self.tongue.mesh) @ self.modes

    def warping_rows(self, nodes: NDArray[np.integer]) -> NDArray[np.float64]:
        """Phi and Psi of some nodes, stacked node by node: (count, 2, 3, mode_count).

        Their product with q is what the warp of a node needs: its linear displacement and its rotation vector.
        """
        by_node = (rows.reshape(-1, 3, self.mode_count)[nodes] for rows in (self.modes, self.rotation_modes))
        return np.stack(list(by_node), axis=1)

    def strain_energy(self, coordinates: NDArray[np.floating]) -> float:
        """1/2 sum of omega_i^2 q_i^2 [J] (Yang 2013, Eq. 6), of coordinates with mode_count elements.

        The energy of the linear tongue before it is warped; docs/design/modal_warping.md compares it
        with that of the warped shape.
        """
        return 0.5 * float(self.eigenvalues @ np.square(coordinates.ravel()))


def nodal_curl(mesh: TetMesh) -> sp.bsr_array:
    """W, (3 node_count, 3 node_count) [1/m] in 3x3 blocks: half the curl of a displacement at the nodes.

    In a tetrahedron half the curl is 1/2 sum_a grad N_a x u_a; a node takes the mean of its tetrahedra,
    weighted by their volumes. Every block is the cross product with a vector.
    """
    share = mesh.volumes[:, None] / (4.0 * mesh.node_volumes[mesh.tets])  # of a tetrahedron in its nodes' means
    weight = 0.5 * share[:, :, None, None] * mesh.shape_gradients[:, None]  # (tet, row node, column node, 3)
    rows = np.repeat(mesh.tets, 4, axis=1).ravel()
    columns = np.tile(mesh.tets, (1, 4)).ravel()
    keys, pair = np.unique(rows.astype(np.int64) * mesh.node_count + columns, return_inverse=True)
    c = np.stack([np.bincount(pair, weights=weight[..., i].ravel(), minlength=len(keys)) for i in range(3)], axis=1)
    zero = np.zeros(len(c))
    blocks = np.stack([zero, -c[:, 2], c[:, 1], c[:, 2], zero, -c[:, 0], -c[:, 1], c[:, 0], zero], axis=1)
    counts = np.bincount(keys // mesh.node_count, minlength=mesh.node_count)
    starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
    size = 3 * mesh.node_count
    pattern = (blocks.reshape(-1, 3, 3), (keys % mesh.node_count).astype(np.int32), starts)
    return sp.bsr_array(pattern, shape=(size, size))
