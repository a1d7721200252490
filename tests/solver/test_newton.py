"""Newton's iteration on small problems with known answers."""

import numpy as np
import pytest

from lingual.solver import newton
from lingual.solver.protocol import StepReport


class Scalar:
    """Minimises W(x) in one unknown; `slope` and `curve` are W' and W''."""

    def __init__(self, slope, curve, constraint=None):
        self.slope, self.curve, self.constraint = slope, curve, constraint

    def residual(self, x):
        return self.slope(x), 1.0

    def gap(self, x):
        return np.zeros(0) if self.constraint is None else self.constraint - x

    def newton_step(self, x, residual, gap):
        curve = self.curve(x)
        if curve == 0.0:
            raise np.linalg.LinAlgError
        if len(gap):
            return gap, -(residual + curve * gap)
        return -residual / curve, gap

    def dual_norm(self, residual, multipliers):
        return float(abs((residual + multipliers) if len(multipliers) else residual)[0])


def solve(problem, x0):
    report = StepReport()
    x, multipliers = newton.solve_step(problem, np.array([x0]), report, 1e-10)
    return x, multipliers, report


def test_a_quadratic_takes_one_iteration():
    x, _, report = solve(Scalar(lambda x: 3.0 * (x - 2.0), lambda x: 3.0), 10.0)
    assert x[0] == pytest.approx(2.0)
    assert (report.iterations, report.converged) == (1, True)


def test_a_smooth_problem_converges_quadratically():
    x, _, report = solve(Scalar(lambda x: np.sinh(x) - 1.0, lambda x: np.cosh(x)), 1.0)
    assert x[0] == pytest.approx(np.arcsinh(1.0), abs=1e-10)
    assert 3 <= report.iterations <= 5
    assert report.residual <= 1e-10


def test_a_step_that_lets_the_residual_grow_tenfold_is_halved():
    """From 6 the tangent is 20 times too soft: the full step would reach -74, half of it reaches -34."""
    visited = []

    def slope(x):
        visited.append(x[0])
        return x - 2.0

    _, _, report = solve(Scalar(slope, lambda x: {10.0: 2.0, 6.0: 0.05}.get(x[0], 1.0)), 10.0)
    np.testing.assert_allclose(visited, [10.0, 6.0, -74.0, -34.0, 2.0])
    assert (report.iterations, report.converged) == (3, True)


def test_a_constraint_is_met_and_its_multiplier_balances_the_residual():
    x, multipliers, report = solve(Scalar(lambda x: x**3, lambda x: 3.0 * x**2, constraint=2.0), 1.0)
    assert report.converged
    assert x[0] == pytest.approx(2.0)
    assert multipliers[0] == pytest.approx(-8.0)


def test_a_singular_system_is_reported_not_raised():
    x, _, report = solve(Scalar(lambda x: x + 1.0, lambda x: 0.0), 5.0)
    assert not report.converged
    assert x[0] == 5.0


def test_a_residual_that_is_not_finite_ends_the_iteration():
    _, _, report = solve(Scalar(lambda x: np.where(x != 5.0, np.nan, x), lambda x: 1.0), 5.0)
    assert (report.iterations, report.converged) == (1, False)


def test_a_problem_without_solution_stops_at_the_limit():
    _, _, report = solve(Scalar(lambda x: x**2 + 1.0, lambda x: 2.0 * x + 1e-3), 0.5)
    assert (report.iterations, report.converged) == (newton.MAXIMUM_ITERATIONS, False)
