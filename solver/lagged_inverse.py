"""The inverse of one reduced Hessian in the null space of the sensor rows, used for many steps.

With A the Hessian of the incremental potential and J the rows, the inverse of the block matrix [A J^T; J 0] has the
blocks Z = A^-1 - A^-1 J^T S J A^-1 (projected inverse) and A^-1 J^T S (response to a gap), S = (J A^-1 J^T)^-1.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from ..model import ReducedModel
from ..model.reduced_forces import ReducedForces
from .constraints import RANK_TOLERANCE, row_space

SMALLEST_EIGENVALUE = 1e-3
"""Share of the inertia's curvature to which negative curvature is lifted."""


class LaggedInverse:
    """Projected inverse and response of one reduced model and one set of imposed sensor coordinates.

    constrained: (sensor_count, 3) bool. constraint_rows: J, (c, n). constraint_basis: an orthonormal basis of
    its row space, (c, n). projected: Z, (n, n); response: (n, c); both set by `renew`.
    """

    def __init__(self, model: ReducedModel, constrained: NDArray[np.bool_], precision_name: str) -> None:
        self._forces = ReducedForces(
            model.tongue.material, model.gradient_operator, model.cubature_weights, precision_name
        )
        self._damping_mass = model.tongue.material.damping_mass
        all_rows = np.kron(model.sensor_rows, np.eye(3))
        self.constraint_rows = np.ascontiguousarray(all_rows[constrained.ravel()])
        self.constraint_basis, self._force_of_carried = row_space(self.constraint_rows)
        n = model.dof_count
        self.projected: NDArray[np.floating] = np.zeros((n, n))
        self.response: NDArray[np.floating] = np.zeros((n, len(self.constraint_rows)))

    def renew(
        self,
        start: NDArray[np.floating],
        now: NDArray[np.floating],
        step: float,
        added_stiffness: NDArray[np.floating] | float = 0.0,
    ) -> None:
        """Takes the Hessian of a step [s] at coordinates `now` that began at `start`, (columns, 3).

        added_stiffness: (n, n) of other forces, positive semidefinite.
        """
        forces = self._forces
        forces.set_coordinates(start.astype(forces.dtype))
        forces.elements.begin_step()
        forces.set_coordinates(now.astype(forces.dtype))
        A = forces.stiffness(step) + np.asarray(added_stiffness, dtype=forces.dtype)
        shift = 1.0 / step**2 + self._damping_mass / step
        np.einsum("ii->i", A)[:] += shift
        inverse = _inverse(A, SMALLEST_EIGENVALUE * shift)
        solved = inverse @ self.constraint_rows.T
        schur = np.linalg.pinv(self.constraint_rows @ solved, rcond=RANK_TOLERANCE, hermitian=True)
        self.response = solved @ schur
        self.projected = inverse - self.response @ solved.T

    def multipliers(self, carried: NDArray[np.floating]) -> NDArray[np.floating]:
        """Forces along the rows (c, ...) of a force given along `constraint_basis`."""
        return self._force_of_carried @ carried


def _inverse(A: NDArray[np.floating], smallest: float) -> NDArray[np.floating]:
    """The inverse of a symmetric matrix; negative curvature counts as `smallest`."""
    potrf, potri = (lapack.spotrf, lapack.spotri) if A.dtype == np.float32 else (lapack.dpotrf, lapack.dpotri)
    factor, info = potrf(A.T, lower=True)
    if info == 0:
        lower, info = potri(factor, lower=True)
    if info != 0:
        values, vectors = np.linalg.eigh(A.astype(np.float64))
        return (vectors / np.maximum(np.abs(values), smallest)) @ vectors.T
    lower = np.tril(lower).astype(np.float64)
    return lower + np.tril(lower, -1).T
