"""The blended quadratic basis (Luo 2017, Eq. 5), local, scaled and mass-orthonormal.

u(x) = sum_j w_j(x) [1, y, y_a y_b]^T Q_j with y = (x - seed_j) / L: the span of Eq. 5 with one weight for
all four types of freedom, which the paper's own weights give too. Every component of u has the same
functions, so the subspace is B (x) I_3 and only B, (node_count, 10 domains), is stored.
"""

import numpy as np
from numpy.typing import NDArray

from ..model import LingualError, TongueModel
from .seeds import Seed

FUNCTIONS_PER_DOMAIN = 10
RANK_TOLERANCE = 1e-9
"""Relative size of a singular value of M^(1/2) B below which a direction is left out."""


def quadratic_functions(points: NDArray[np.float64], centre: NDArray[np.float64], length: float) -> NDArray[np.float64]:
    """1, y, squares and mixed products of y = (points - centre) / length, (point_count, 10)."""
    y = (points - centre) / length
    mixed = np.stack([y[:, 0] * y[:, 1], y[:, 1] * y[:, 2], y[:, 0] * y[:, 2]], axis=1)
    return np.column_stack([np.ones(len(y)), y, y**2, mixed])


def blended_quadratic_basis(
    tongue: TongueModel, seeds: list[Seed], weights: NDArray[np.float64]
) -> NDArray[np.float64]:
    """B (node_count, columns) with B^T M B = I for the lumped mass M; columns = 10 per domain.

    Directions that the mesh cannot tell apart are dropped, so a very coarse mesh gives fewer columns.
    Raises LingualError when not even one function per domain is independent.
    """
    nodes = tongue.mesh.nodes
    length = 0.5 * float(np.ptp(nodes, axis=0).max())
    functions = [quadratic_functions(nodes, seed.centre, length) for seed in seeds]
    raw = np.hstack([w[:, None] * f for f, w in zip(functions, weights.T, strict=True)])
    root_mass = np.sqrt(tongue.node_masses)[:, None]
    left, singular, _ = np.linalg.svd(root_mass * raw, full_matrices=False)
    rank = int(np.sum(singular > RANK_TOLERANCE * singular[0]))
    if rank < len(seeds):
        raise LingualError(f"The mesh of '{tongue.name}' is too coarse for {len(seeds)} domains; ask for fewer.")
    basis = np.ascontiguousarray(left[:, :rank] / root_mass)
    basis[tongue.fixed_nodes] = 0.0  # the factorisation leaves rounding there
    return basis
