"""Minimisation of known functions under constraints by the batched quasi-Newton kernels."""

import numpy as np
import pytest
import warp as wp

from lingual.kernels.quasi_newton import CONVERGED, quasi_newton_kernels

N, TONGUES, PAIRS, STEP = 12, 3, 6, 0.5


class Problem:
    """Minimises f_t(x) + |x - h v|^2 / (2 h^2) subject to J x = 0 for every column t, by the kernels alone."""

    def __init__(self, types, device, force, J, inverse, velocity, tolerance):
        self.force, self.types, self.device = force, types, device
        self.projected = inverse - inverse @ J.T @ np.linalg.solve(J @ inverse @ J.T, J @ inverse)
        basis = np.zeros((4 * -(-len(J) // 4), N))
        basis[: len(J)] = np.linalg.qr(J.T)[0].T
        names = ("force", "load", "trial", "direction", "accepted", "gradient", "fresh", "q", "z")
        self.arrays = {name: self._zeros(N, TONGUES) for name in names}
        self.velocity, self.basis = self._array(velocity), self._array(basis)
        self.damping = self._zeros(TONGUES)
        self.carried = self._zeros(len(basis), TONGUES)
        count = wp.zeros(TONGUES, dtype=wp.int32, device=device)
        self.pairs = [self._zeros(PAIRS, N, TONGUES), self._zeros(PAIRS, N, TONGUES)]
        self.pairs += [self._zeros(PAIRS, TONGUES), self._zeros(PAIRS, TONGUES), count]
        self.length, self.slope, self.error = self._array(np.ones(TONGUES)), self._zeros(TONGUES), self._zeros(TONGUES)
        self.state = wp.zeros(TONGUES, dtype=wp.int32, device=device)
        self.tolerance = tolerance

    def _zeros(self, *shape):
        return wp.zeros(shape, dtype=self.types.scalar, device=self.device)

    def _array(self, values):
        return wp.array(values, dtype=self.types.scalar, device=self.device)

    def run(self, evaluations):
        kernels, a, scalar = quasi_newton_kernels(self.types.numpy.name), self.arrays, self.types.scalar
        block = 1 if self.device == "cpu" else 32
        for _ in range(evaluations):
            a["force"].assign(self.force(a["trial"].numpy()))
            inputs = [a["force"], self.velocity, a["load"], self.basis, scalar(STEP), self.damping, scalar(1e-12)]
            inputs += [scalar(self.tolerance), a["trial"], a["direction"]]
            outputs = [a["accepted"], a["gradient"], a["fresh"], self.carried, *self.pairs]
            outputs += [self.length, self.slope, self.error, self.state, a["q"]]
            size = (TONGUES, block)
            wp.launch(kernels.assess, size, inputs, outputs, device=self.device, block_dim=block)
            a["z"].assign(self.projected @ a["q"].numpy())
            inputs = [a["z"], a["accepted"], a["gradient"], *self.pairs, self.length, self.state]
            outputs = [a["z"], a["direction"], self.slope, a["trial"]]
            wp.launch(kernels.propose, size, inputs, outputs, device=self.device, block_dim=block)
        return a["accepted"].numpy(), self.state.numpy()


@pytest.fixture
def random():
    return np.random.default_rng(7)


@pytest.fixture
def J(random):
    return random.standard_normal((2, N))


def test_a_quadratic_is_minimised_under_its_constraints(types, device, J, random):
    """Against the block system, each column with another right-hand side; the inverse is of a wrong Hessian."""
    root = random.standard_normal((N, N))
    A, b = root @ root.T + np.eye(N), random.standard_normal((N, TONGUES))
    velocity = random.standard_normal((N, TONGUES))
    wrong = np.linalg.inv(A + 0.5 * np.diag(np.diag(A)) + np.eye(N) / STEP**2)
    tolerance = 1e-10 if types.numpy == np.float64 else 1e-5
    problem = Problem(types, device, lambda x: A @ x - b, J, wrong, velocity, tolerance)
    x, state = problem.run(60)
    assert (state == CONVERGED).all()
    H = A + np.eye(N) / STEP**2
    system = np.block([[H, J.T], [J, np.zeros((2, 2))]])
    right = np.concatenate([b + velocity / STEP, np.zeros((2, TONGUES))])
    np.testing.assert_allclose(x, np.linalg.solve(system, right)[:N], atol=20 * tolerance * np.abs(x).max())
    # What the constraints carry is the gradient's part along their rows.
    basis, gradient = np.linalg.qr(J.T)[0].T, A @ x - b + x / STEP**2 - velocity / STEP
    carried = problem.carried.numpy()[:2]
    np.testing.assert_allclose(carried, basis @ gradient, atol=100 * tolerance * np.abs(carried).max())


def test_a_proposal_that_overshoots_is_shortened(types, device, J, random):
    """A stiffening potential with an inverse that believes it ten times too soft."""
    soft = 10.0 * np.eye(N)
    velocity = random.standard_normal((N, TONGUES))
    tolerance = 1e-8 if types.numpy == np.float64 else 1e-4
    problem = Problem(types, device, lambda x: x + x**3 - 1.0, J, soft, velocity, tolerance)
    refused = False
    for _ in range(80):
        x, state = problem.run(1)
        refused |= bool((state == 2).any())
    assert refused
    assert (state == CONVERGED).all()
    gradient = x + x**3 - 1.0 + x / STEP**2 - velocity / STEP
    basis = np.linalg.qr(J.T)[0]
    remaining = gradient - basis @ (basis.T @ gradient)
    assert np.abs(remaining).max() < 10 * tolerance * np.abs(gradient).max()
    np.testing.assert_allclose(J @ x, 0.0, atol=1e-5 if types.numpy == np.float32 else 1e-12)


def test_a_force_that_is_not_finite_shortens_the_step(types, device, J, random):
    """A barrier that the first proposal jumps over."""
    def force(x):
        with np.errstate(invalid="ignore"):
            return np.where(x < 0.5, -1.0 + 1e-3 / np.sqrt(0.5 - x), np.nan)

    problem = Problem(types, device, force, np.eye(2, N), 5.0 * np.eye(N), np.zeros((N, TONGUES)), 1e-4)
    x, state = problem.run(60)
    assert (state == CONVERGED).all()
    assert np.isfinite(x).all()
    assert (x < 0.5).all()


def test_converged_tongues_stand_still(types, device, J, random):
    root = random.standard_normal((N, N))
    A = root @ root.T + np.eye(N)
    b = random.standard_normal((N, TONGUES)) * [0.0, 1.0, 1.0]
    tolerance = 1e-10 if types.numpy == np.float64 else 1e-5
    inverse = np.linalg.inv(A + 5.0 * np.eye(N))
    problem = Problem(types, device, lambda x: A @ x - b, J, inverse, np.zeros((N, TONGUES)), tolerance)
    x, state = problem.run(1)
    assert state[0] == CONVERGED
    assert state[1] != CONVERGED
    later, _ = problem.run(40)
    np.testing.assert_array_equal(later[:, 0], x[:, 0])
