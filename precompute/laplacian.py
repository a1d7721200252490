"""The Laplace operator of linear tetrahedra, for weights that are diffused or harmonic.

Entry (a, b) is the integral of grad N_a . grad N_b over the mesh, with N the linear shape functions: symmetric,
positive semidefinite, rows summing to zero, natural (no-flux) boundary.
"""

import numpy as np
import scipy.sparse as sp

from ..model import TetMesh


def laplacian(mesh: TetMesh) -> sp.csr_array:
    """Stiffness of the scalar Laplace operator [m], (node_count, node_count)."""
    gradients = mesh.shape_gradients
    local = np.einsum("eai,ebi,e->eab", gradients, gradients, mesh.volumes)
    rows = np.repeat(mesh.tets, 4, axis=1).ravel()
    columns = np.tile(mesh.tets, (1, 4)).ravel()
    return sp.csr_array((local.ravel(), (rows, columns)), shape=(mesh.node_count, mesh.node_count))
