"""The pressure subspace of a tongue, and what its constraints look like in reduced coordinates (Luo 2017, section 8).

With pressures p = P y, volume is asked for only as the subspace sees it: c(Q) = P^T V (J(Q) - 1), V the element
volumes at rest and J = det F. P is orthonormal in V, so |c|^2 is the volume-weighted square of the excess J - 1,
projected on the subspace. At run time c is a weighted sum over the cubature elements alone.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class PressureSubspace:
    """What precomputation makes for one reduced model.

    basis: P [m^-3/2], (tet_count, mode_count); P^T diag(V) P = I; the first column is the uniform pressure.
    cubature_rows: [m^3/2], (mode_count, cubature_count): c = cubature_rows @ (J - 1) of the cubature elements.
    cubature_error: relative error of the Jacobian of c on held-out poses, root mean square.
    volume_coefficients: of the whole volume's polynomial (volume_polynomial), (columns + 3, pair_count).
    key_frame_count: equilibria that the basis was made of.
    """

    basis: NDArray[np.float64]
    cubature_rows: NDArray[np.float64]
    cubature_error: float
    volume_coefficients: NDArray[np.float64]
    key_frame_count: int

    @property
    def mode_count(self) -> int:
        return self.basis.shape[1]


def excess_jacobian(gradient_operator: NDArray[np.float64], coordinates: NDArray[np.floating]) -> NDArray[np.float64]:
    """d(J_e - 1)/dQ of each element at coordinates (columns, 3), flat index 3 k + i: (element_count, 3 columns).

    gradient_operator: H of the elements, (3 * element_count, columns).
    """
    G = (gradient_operator @ coordinates).reshape(-1, 3, 3)
    F = np.eye(3) + G  # transposed: row j holds dx/dX_j
    cofactor = np.stack([np.cross(F[:, (j + 1) % 3], F[:, (j + 2) % 3]) for j in range(3)], axis=1)
    stacked = gradient_operator.reshape(len(G), 3, -1).transpose(0, 2, 1)
    jacobian: NDArray[np.float64] = np.matmul(stacked, cofactor).reshape(len(G), -1)
    return jacobian
