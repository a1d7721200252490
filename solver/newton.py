"""Newton's method for one implicit step with linear sensor constraints, shared by all solvers.

Minimises over the displacement x (mass-orthonormal or nodal unknowns)

    W(x) = |x - x0 - h v0|_M^2 / (2 h^2) + damping_mass |x - x0|_M^2 / (2 h) + elastic and viscous energy - f.x

subject to J x = g. Its stationarity is implicit Euler with the full residual; Luo 2017, Eq. 11, omits the
internal force of the linearisation point, which would let the tongue drift from its rest shape.
"""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .protocol import StepReport

TOLERANCE = 1e-8
"""Relative residual in the mass norm at which a step has converged."""
MAXIMUM_ITERATIONS = 15
LINE_SEARCH_HALVINGS = 6
NEGLIGIBLE_DISPLACEMENT = 1e-6
"""[m]. Residuals are relative to no less than the inertia of the whole tongue moving so far in a step."""


def smallest_scale(mass: float, dt: float) -> float:
    """Least magnitude of force, in the norm dual to the mass, that a residual is compared with.

    mass [kg] of the whole tongue. Without it, a tongue that has come to rest would be asked to converge
    relative to its own rounding errors.
    """
    return NEGLIGIBLE_DISPLACEMENT * mass**0.5 / dt**2


class StepProblem(Protocol):
    """One step's equations, as Newton's method sees them. Vectors are flat; arrays may be reused."""

    def residual(self, x: NDArray) -> tuple[NDArray, float]:
        """Gradient of W without constraint forces, and the magnitude of its largest term (dual norm)."""
        ...

    def gap(self, x: NDArray) -> NDArray:
        """What the constraints lack: g - J x."""
        ...

    def newton_step(self, x: NDArray, residual: NDArray, gap: NDArray) -> tuple[NDArray, NDArray]:
        """Solution (dx, multipliers) of the linearised constrained equations at the last residual's x."""
        ...

    def dual_norm(self, residual: NDArray, multipliers: NDArray) -> float:
        """Norm of residual + J^T multipliers, dual to the mass norm."""
        ...


def solve_step(problem: StepProblem, x: NDArray, report: StepReport, tolerance: float) -> tuple[NDArray, NDArray]:
    """The converged x and multipliers, starting from x; `report` is filled.

    Once the constraints hold, a Newton step that makes the residual grow more than tenfold is halved, a few
    times at most; before that the residual says nothing, since it contains what meeting the targets costs.
    """
    residual, _ = problem.residual(x)
    gap = problem.gap(x)
    multipliers = np.zeros_like(gap)
    error = np.inf
    report.converged, report.residual = False, np.inf
    for iteration in range(1, MAXIMUM_ITERATIONS + 1):
        report.iterations = iteration
        try:
            dx, multipliers = problem.newton_step(x, residual, gap)
        except np.linalg.LinAlgError:
            break
        feasible = bool(np.all(np.abs(gap) <= 1e-12))
        x, residual, error = _advance(problem, x, dx, multipliers, error if feasible else np.inf)
        gap = problem.gap(x)
        report.residual = error
        if not np.isfinite(error):
            break
        if error <= tolerance:
            report.converged = True
            break
    return x, multipliers


def _advance(
    problem: StepProblem, x: NDArray, dx: NDArray, multipliers: NDArray, previous_error: float
) -> tuple[NDArray, NDArray, float]:
    """x + t dx with the largest t in 1, 1/2, ... that does not let the error grow tenfold.

    Returns the new x, its residual and its relative error.
    """
    length = 1.0
    for _ in range(LINE_SEARCH_HALVINGS):
        trial = x + length * dx
        residual, scale = problem.residual(trial)
        error = problem.dual_norm(residual, multipliers) / scale
        if error <= 10.0 * previous_error:
            break
        length *= 0.5
    return trial, residual, error
