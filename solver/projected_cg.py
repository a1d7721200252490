"""Symmetric systems with a few constraints, by projected preconditioned conjugate gradients.

[A J^T; J 0] [x; y] = [f; g], with A given by its products and J of few dense rows. The preconditioner is
the same block matrix with A replaced by a factorised P of an earlier time, so every iterate satisfies
J x = g (Gould, Hribar and Nocedal 2001, algorithm 2.1).
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Solve = Callable[[NDArray], NDArray]
"""Applies the inverse of a factorised matrix to a vector (n,) or to columns (n, m)."""

RELATIVE_TOLERANCE = 1e-3
"""Reduction of the preconditioned residual: an inexact Newton step costs less than it saves."""
MAXIMUM_ITERATIONS = 200
SAME_STEP = 0.01
"""Relative change of the time step that a lagged factor does not notice: recorded times are rounded."""


class LaggedPreconditioner:
    """A factor of some earlier A, with the constraints' Schur complement.

    aged_iterations: the factor is worth renewing when it needs more iterations than these. The
        default suits a sparse factor, which costs about fifty of its solutions.
    """

    def __init__(self, aged_iterations: int = 12) -> None:
        self.aged_iterations = aged_iterations
        self._solve: Solve | None = None
        self._dt = 0.0

    def forget(self) -> None:
        """Factorise before the next use."""
        self._solve = None

    def begin_step(self, dt: float, constraints_changed: bool) -> None:
        """Forgets the factor when it no longer suits: other constraints, or clearly another time step [s]."""
        if constraints_changed or abs(dt - self._dt) > SAME_STEP * dt:
            self.forget()
            self._dt = dt

    def renew(self, solve: Solve, J: NDArray) -> None:
        """Takes a new factor. Raises numpy.linalg.LinAlgError when the constraints repeat each other."""
        self._solve = None
        self._solved_rows = solve(np.ascontiguousarray(J.T)) if len(J) else J.T.copy()
        self._schur_inverse = np.linalg.inv(J @ self._solved_rows)
        self._solve = solve

    @property
    def ready(self) -> bool:
        return self._solve is not None

    def solve(self, J: NDArray, f: NDArray, g: NDArray) -> tuple[NDArray, NDArray]:
        """x and y of the block system with P in place of A."""
        assert self._solve is not None
        x = self._solve(f)
        y = self._schur_inverse @ (J @ x - g)
        return x - self._solved_rows @ y, y


def projected_cg(
    product: Callable[[NDArray], NDArray],
    factorise: Callable[[], Solve],
    J: NDArray,
    f: NDArray,
    g: NDArray,
    preconditioner: LaggedPreconditioner,
) -> tuple[NDArray, NDArray]:
    """x (n,) and multipliers y (m,); the preconditioner is renewed when it is missing or has aged.

    product: p -> A p. factorise: makes a factor of the present A.
    Raises numpy.linalg.LinAlgError when A is not positive definite in the constraints' null space.
    """
    if preconditioner.ready:
        solution = _iterate(product, J, f, g, preconditioner, preconditioner.aged_iterations)
        if solution is not None:
            return solution
    preconditioner.renew(factorise(), J)
    solution = _iterate(product, J, f, g, preconditioner, MAXIMUM_ITERATIONS)
    if solution is None:
        preconditioner.forget()
        raise np.linalg.LinAlgError("conjugate gradients did not converge")
    return solution


def _iterate(
    product: Callable[[NDArray], NDArray],
    J: NDArray,
    f: NDArray,
    g: NDArray,
    preconditioner: LaggedPreconditioner,
    limit: int,
) -> tuple[NDArray, NDArray] | None:
    """The solution, or None when `limit` iterations do not reach it or A curves down."""
    zero = np.zeros_like(g)
    x, y = preconditioner.solve(J, f, g)
    residual = f - product(x) - J.T @ y
    first = float(np.abs(f @ x)) + float(np.abs(g @ y))
    p = np.zeros_like(f)
    previous = 1.0
    for iteration in range(limit + 1):
        direction, correction = preconditioner.solve(J, residual, zero)
        y = y + correction
        residual = residual - J.T @ correction
        current = float(residual @ direction)
        if current <= RELATIVE_TOLERANCE**2 * first:
            return x, y
        p = direction + (current / previous) * p if iteration else direction
        Ap = product(p)
        curvature = float(p @ Ap)
        if curvature <= 0.0 or not np.isfinite(curvature):
            return None
        length = current / curvature
        x = x + length * p
        residual = residual - length * Ap
        previous = current
    return None
