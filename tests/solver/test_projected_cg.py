"""Projected conjugate gradients against a dense solution of the whole system."""

import numpy as np
import pytest
from scipy.linalg import cho_factor, cho_solve

from lingual.solver import projected_cg as module
from lingual.solver.projected_cg import LaggedPreconditioner, projected_cg

RNG = np.random.default_rng(8)
SIZE = 30
J = RNG.standard_normal((4, SIZE))
F, G = RNG.standard_normal(SIZE), RNG.standard_normal(4)


@pytest.fixture
def A():
    root = RNG.standard_normal((SIZE, SIZE))
    return root @ root.T + np.eye(SIZE)


class Factory:
    """Makes factors of a matrix and counts them."""

    def __init__(self, matrix):
        self.matrix, self.count = matrix, 0

    def __call__(self):
        self.count += 1
        factor = cho_factor(self.matrix)
        return lambda right: cho_solve(factor, right)


def dense(A, J, f, g):
    whole = np.block([[A, J.T], [J, np.zeros((len(J), len(J)))]])
    solution = np.linalg.solve(whole, np.concatenate([f, g]))
    return solution[: len(f)], solution[len(f) :]


@pytest.mark.parametrize("rows", [0, 1, 4])
def test_with_a_fresh_factor_the_answer_is_exact(A, rows):
    x, y = projected_cg(A.__matmul__, Factory(A), J[:rows], F, G[:rows], LaggedPreconditioner())
    expected_x, expected_y = dense(A, J[:rows], F, G[:rows])
    np.testing.assert_allclose(x, expected_x, rtol=1e-7, atol=1e-9)
    np.testing.assert_allclose(y, expected_y, rtol=1e-7, atol=1e-9)


def test_a_lagged_factor_serves_a_nearby_matrix_and_the_constraints_stay_exact(A, monkeypatch):
    monkeypatch.setattr(module, "RELATIVE_TOLERANCE", 1e-9)
    preconditioner, factory = LaggedPreconditioner(aged_iterations=SIZE), Factory(A)
    projected_cg(A.__matmul__, factory, J, F, G, preconditioner)
    nearby = A + np.diag(np.linspace(0.0, 2.0, SIZE))
    x, y = projected_cg(nearby.__matmul__, Factory(nearby), J, F, G, preconditioner)
    expected_x, expected_y = dense(nearby, J, F, G)
    np.testing.assert_allclose(J @ x, G, atol=1e-12)
    np.testing.assert_allclose(x, expected_x, atol=1e-6)
    np.testing.assert_allclose(y, expected_y, atol=1e-5)
    assert factory.count == 1


def test_an_aged_factor_is_renewed(A):
    preconditioner, stale = LaggedPreconditioner(), Factory(np.eye(SIZE))
    projected_cg(np.eye(SIZE).__matmul__, stale, J, F, G, preconditioner)
    hard = A @ A @ A
    fresh = Factory(hard)
    x, _ = projected_cg(hard.__matmul__, fresh, J, F, G, preconditioner)
    assert fresh.count == 1
    np.testing.assert_allclose(x, dense(hard, J, F, G)[0], atol=1e-6)


def test_a_matrix_that_is_definite_only_where_the_constraints_allow_is_solved():
    """A = -1 along the constrained coordinate, positive elsewhere."""
    A = np.diag([-1.0, 2.0, 3.0])
    row = np.array([[1.0, 0.0, 0.0]])
    preconditioner = LaggedPreconditioner()
    preconditioner.renew(lambda right: right, row)
    x, y = projected_cg(A.__matmul__, Factory(np.eye(3)), row, np.ones(3), np.array([5.0]), preconditioner)
    np.testing.assert_allclose(x, [5.0, 0.5, 1 / 3], atol=1e-3)
    np.testing.assert_allclose(y, [6.0], atol=1e-2)


def test_an_indefinite_matrix_is_an_error():
    A = np.diag([-1.0, 2.0, 3.0])
    with pytest.raises(np.linalg.LinAlgError):
        projected_cg(
            A.__matmul__, lambda: lambda right: right, np.zeros((0, 3)), np.ones(3), np.zeros(0), LaggedPreconditioner()
        )


def test_a_preconditioner_whose_constraints_repeat_stays_unready():
    preconditioner = LaggedPreconditioner()
    with pytest.raises(np.linalg.LinAlgError):
        preconditioner.renew(lambda right: right, np.array([[1.0, 0.0], [1.0, 0.0]]))
    assert not preconditioner.ready


@pytest.mark.parametrize(
    ("dt", "constraints_changed", "kept"), [(0.01, False, True), (0.02, False, False), (0.01, True, False)]
)
def test_a_factor_outlives_rounding_of_the_time_step_but_not_another_problem(dt, constraints_changed, kept):
    preconditioner = LaggedPreconditioner()
    preconditioner.begin_step(0.01, True)
    preconditioner.renew(lambda right: right, np.array([[1.0, 0.0]]))
    preconditioner.begin_step(dt * (1.0 + 1e-12), constraints_changed)
    assert preconditioner.ready == kept
