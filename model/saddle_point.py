"""Dense solution of a symmetric system with linear constraints: [A J^T; J 0] [x; y] = [f; g]."""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack


def solve_saddle_point(
    A: NDArray[np.floating], J: NDArray[np.floating], f: NDArray[np.floating], g: NDArray[np.floating]
) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
    """x (n,) and multipliers y (m,) for symmetric A (n, n), J (m, n) of full row rank.

    A Cholesky factor and the Schur complement J A^-1 J^T while A is positive definite, a symmetric
    indefinite factor of the whole system otherwise (a compressed StVK tangent need not be definite
    outside the constraints' null space). Raises numpy.linalg.LinAlgError when the system is singular.
    """
    potrf, potrs, sysv = (
        (lapack.spotrf, lapack.spotrs, lapack.ssysv)
        if A.dtype == np.float32
        else (lapack.dpotrf, lapack.dpotrs, lapack.dsysv)
    )
    factor, info = potrf(A.T, lower=True)
    if info == 0:
        solved, _ = potrs(factor, np.column_stack([f, J.T]), lower=True)
        x0, Z = solved[:, 0], solved[:, 1:]
        if len(J) == 0:
            return x0, np.zeros(0, dtype=A.dtype)
        y = np.linalg.solve(J @ Z, J @ x0 - g)
        return x0 - Z @ y, y
    whole = np.block([[A, J.T], [J, np.zeros((len(J), len(J)), dtype=A.dtype)]])
    _, _, solution, info = sysv(whole, np.concatenate([f, g]))
    if info != 0:
        raise np.linalg.LinAlgError("the constrained system is singular")
    return solution[: len(f)], solution[len(f) :]
