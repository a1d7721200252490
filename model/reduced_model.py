"""A tongue's reduced subspace: blended quadratic basis and cubature (what precomputation makes)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .tongue_model import TongueModel


@dataclass(frozen=True, eq=False)
class ReducedModel:
    """The subspace u = B Q of one tongue (Luo 2017, Eq. 5, in the Kronecker form B (x) I_3).

    tongue: whose subspace it is.
    domain_names: one per domain; seeds: (domain_count, 3) [m].
    domain_weights: (node_count, domain_count), in [0, 1]; rows sum to one or less (the rest is ground).
    basis: B, (node_count, column_count), mass-orthonormal [1/sqrt(kg)], zero at fixed nodes.
    cubature_elements: (cubature_count,) element indices; cubature_weights: their weights [m^3].
    cubature_error: relative force error on held-out poses, root mean square (NaN if not measured).
    """

    tongue: TongueModel
    domain_names: tuple[str, ...]
    seeds: NDArray[np.float64]
    domain_weights: NDArray[np.float64]
    basis: NDArray[np.float64]
    cubature_elements: NDArray[np.int64]
    cubature_weights: NDArray[np.float64]
    cubature_error: float = float("nan")

    @property
    def domain_count(self) -> int:
        return len(self.domain_names)

    @property
    def column_count(self) -> int:
        return self.basis.shape[1]

    @property
    def dof_count(self) -> int:
        """Degrees of freedom: three per column of the basis."""
        return 3 * self.column_count

    @cached_property
    def gradient_operator(self) -> NDArray[np.float64]:
        """H of the cubature elements, (3 * cubature_count, column_count) [1/(m sqrt(kg))]."""
        return gradient_operator(self.tongue, self.basis, self.cubature_elements)

    @cached_property
    def sensor_rows(self) -> NDArray[np.float64]:
        """Basis at the sensors, (sensor_count, column_count): sensor displacement = rows @ Q."""
        return self.tongue.sensors.weights @ self.basis


def gradient_operator(
    tongue: TongueModel, basis: NDArray[np.float64], elements: NDArray[np.integer]
) -> NDArray[np.float64]:
    """Row 3 e + j: derivative along X_j of every column of `basis` in element e; (3 * count, columns)."""
    mesh = tongue.mesh
    corner_basis = basis[mesh.tets[elements]]  # (count, 4, columns)
    stacked = np.einsum("eaj,eak->ejk", mesh.shape_gradients[elements], corner_basis, optimize=True)
    return np.ascontiguousarray(stacked.reshape(-1, basis.shape[1]))
