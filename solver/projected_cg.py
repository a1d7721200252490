"""Sparse symmetric systems with a few constraints, by projected preconditioned conjugate gradients.

[A J^T; J 0] [x; y] = [f; g], with A large and sparse and J of few dense rows. The preconditioner is the
same block matrix with A replaced by a factorised P of an earlier step, so every iterate satisfies
J x = g (Gould, Hribar and Nocedal 2001, algorithm 2.1).
"""

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as sla
from numpy.typing import NDArray

RELATIVE_TOLERANCE = 1e-3
"""Reduction of the preconditioned residual: an inexact Newton step costs less than it saves."""
AGED_ITERATIONS = 25
MAXIMUM_ITERATIONS = 400


class LaggedPreconditioner:
    """A sparse factor of some earlier A, with the constraints' Schur complement."""

    def __init__(self) -> None:
        self._factor: sla.SuperLU | None = None

    def forget(self) -> None:
        """The constraints or the time step have changed: factorise before the next use."""
        self._factor = None

    def refresh(self, A: sp.csr_array, J: NDArray) -> None:
        """Factorises A. Raises numpy.linalg.LinAlgError when A is singular."""
        options = {"SymmetricMode": True}
        try:
            self._factor = sla.splu(A.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
        except RuntimeError as error:
            raise np.linalg.LinAlgError(str(error)) from error
        self._solved_rows = self._factor.solve(J.T) if len(J) else np.zeros((A.shape[0], 0))
        self._schur = J @ self._solved_rows

    @property
    def ready(self) -> bool:
        return self._factor is not None

    def solve(self, J: NDArray, f: NDArray, g: NDArray) -> tuple[NDArray, NDArray]:
        """x and y of the block system with P in place of A."""
        assert self._factor is not None
        x = self._factor.solve(f)
        if len(J) == 0:
            return x, g
        y = np.linalg.solve(self._schur, J @ x - g)
        return x - self._solved_rows @ y, y


def projected_cg(
    A: sp.csr_array, J: NDArray, f: NDArray, g: NDArray, preconditioner: LaggedPreconditioner
) -> tuple[NDArray, NDArray]:
    """x (n,) and multipliers y (m,); the preconditioner is renewed when it is missing or has aged.

    Raises numpy.linalg.LinAlgError when A is not positive definite in the constraints' null space.
    """
    if preconditioner.ready:
        x, y, iterations, solved = _iterate(A, J, f, g, preconditioner, AGED_ITERATIONS)
        if solved:
            return x, y
    preconditioner.refresh(A, J)
    x, y, iterations, solved = _iterate(A, J, f, g, preconditioner, MAXIMUM_ITERATIONS)
    if not solved:
        raise np.linalg.LinAlgError(f"conjugate gradients stopped after {iterations} iterations")
    return x, y


def _iterate(
    A: sp.csr_array, J: NDArray, f: NDArray, g: NDArray, preconditioner: LaggedPreconditioner, limit: int
) -> tuple[NDArray, NDArray, int, bool]:
    zero = np.zeros(len(J))
    x, y = preconditioner.solve(J, f, g)
    residual = f - A @ x - J.T @ y
    direction, correction = preconditioner.solve(J, residual, zero)
    y = y + correction
    residual = residual - J.T @ correction
    product = float(residual @ direction)
    start = max(product, float(f @ x), 0.0)
    p = direction
    for iteration in range(limit):
        if product <= RELATIVE_TOLERANCE**2 * start:
            return x, y, iteration, True
        Ap = A @ p
        curvature = float(p @ Ap)
        if curvature <= 0.0:
            return x, y, iteration, False
        length = product / curvature
        x = x + length * p
        residual = residual - length * Ap
        direction, correction = preconditioner.solve(J, residual, zero)
        y = y + correction
        residual = residual - J.T @ correction
        next_product = float(residual @ direction)
        p = direction + (next_product / product) * p
        product = next_product
    return x, y, limit, False
