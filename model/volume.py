"""Element volumes at any shape and the discrete divergence: their gradient with respect to the free nodes.

D of D dx = dV has one row an element; at the present shape x its entries are the area vectors
dV/dx_1 = (x_2 - x_0) x (x_3 - x_0) / 6 and so on. D^T p is the nodal force of element pressures p
(Irving, Schroeder and Fedkiw 2007, section 3; Luo 2017, Eq. 15-17).
"""

import numpy as np
import scipy.sparse as sp
import warp as wp
from numpy.typing import NDArray

from ..kernels.volume import volume_kernels
from .tet_mesh import TetMesh

COMPLIANCE_LENGTH = 0.010
"""[m]. Corrections minimise |dx|^2 + (this length)^2 (volume excess)^2 over the tongue: an excess spread over less
than this length is left alone. docs/design/volume.md says how it was chosen, and why a subspace takes less."""
SUBSPACE_COMPLIANCE_LENGTH = 0.005
"""[m]. A subspace cannot remove every excess that it sees; asked more firmly, it distorts elements elsewhere."""


class ElementVolumes:
    """Volumes and divergence of one mesh on the CPU, in double precision.

    mesh: what is measured. free_nodes: sorted indices of the nodes that move; columns of D are theirs, 3 a node.

    volumes: signed volume of each element [m^3], (tet_count,), at the shape set last.
    divergence: D [m^2], (tet_count, 3 free) csr, at the shape set last. Both are overwritten by `set_positions`.
    """

    def __init__(self, mesh: TetMesh, free_nodes: NDArray[np.int64]) -> None:
        self.mesh = mesh
        free_index = np.full(mesh.node_count, -1, dtype=np.int64)
        free_index[free_nodes] = np.arange(len(free_nodes))
        columns = (3 * free_index[mesh.tets][:, :, None] + np.arange(3)).reshape(mesh.tet_count, 12)
        self._kept = columns >= 0
        row_starts = np.concatenate([[0], np.cumsum(self._kept.sum(axis=1))]).astype(np.int32)
        indices = columns[self._kept].astype(np.int32)
        shape = (mesh.tet_count, 3 * len(free_nodes))
        self.divergence = sp.csr_array((np.zeros(len(indices)), indices, row_starts), shape=shape)
        self._position: wp.array = wp.zeros(mesh.node_count, dtype=wp.vec3d, device="cpu")
        volumes: wp.array = wp.zeros(mesh.tet_count, dtype=wp.float64, device="cpu")
        gradients: wp.array = wp.zeros((mesh.tet_count, 4), dtype=wp.vec3d, device="cpu")
        tets: wp.array = wp.array(mesh.tets, dtype=wp.int32, device="cpu")
        self.volumes = volumes.numpy()
        self._gradients = gradients.numpy().reshape(mesh.tet_count, 12)
        self._launch = wp.launch(
            volume_kernels("float64").element_volumes,
            mesh.tet_count,
            [self._position, tets],
            [volumes, gradients],
            device="cpu",
            record_cmd=True,
        )
        self.set_positions(mesh.nodes)

    def set_positions(self, nodes: NDArray[np.floating]) -> None:
        """Evaluates `volumes` and `divergence` at node positions (node_count, 3) [m]."""
        self._position.assign(nodes)
        self._launch.launch()
        self.divergence.data[:] = self._gradients[self._kept]

    @property
    def excess(self) -> NDArray[np.float64]:
        """V_e / V0_e - 1 = det F - 1 of each element, (tet_count,), at the shape set last."""
        return self.volumes / self.mesh.volumes - 1.0
