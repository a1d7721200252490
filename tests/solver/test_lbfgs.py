"""Limited-memory BFGS on small problems with known answers."""

import numpy as np

from lingual.solver import lbfgs
from lingual.solver.protocol import StepReport

RNG = np.random.default_rng(9)
SIZE = 12
ROOT = RNG.standard_normal((SIZE, SIZE))
STIFFNESS = ROOT @ ROOT.T + np.eye(SIZE)
POOR = np.diag(np.r_[10.0, 20.0, 30.0, np.zeros(SIZE - 3)])
ROWS = RNG.standard_normal((2, SIZE))


class Quartic:
    """Minimises x.A x / 2 + c sum x^4 / 4 - f.x subject to J x = g; P is the tangent where it was renewed."""

    def __init__(self, load, target=None, cubic=0.0, factor=None):
        self.load, self.cubic = load, cubic
        self.J = ROWS if target is not None else ROWS[:0]
        self.target = np.zeros(0) if target is None else target
        self.P = factor
        self.renewed_at = []

    def residual(self, x):
        return STIFFNESS @ x + self.cubic * x**3 - self.load, 1.0

    def gap(self, x):
        return self.target - self.J @ x

    def dual_norm(self, residual, multipliers):
        return float(np.linalg.norm(residual + self.J.T @ multipliers))

    def constraint_force(self, multipliers):
        return self.J.T @ multipliers

    @property
    def ready(self):
        return self.P is not None

    def renew(self, x):
        self.renewed_at.append(x.copy())
        self.P = STIFFNESS + np.diag(3.0 * self.cubic * x**2)

    def precondition(self, force, gap):
        rows = len(self.J)
        whole = np.block([[self.P, self.J.T], [self.J, np.zeros((rows, rows))]])
        solution = np.linalg.solve(whole, np.concatenate([force, gap]))
        return solution[:SIZE], solution[SIZE:]


def solve(problem, bfgs=None, x=None):
    report = StepReport()
    x = np.zeros(SIZE) if x is None else x
    x, multipliers = (bfgs or lbfgs.LaggedBfgs()).solve_step(problem, x, report, 1e-10)
    return x, multipliers, report


def test_a_quadratic_with_its_own_factor_takes_one_iteration():
    problem = Quartic(RNG.standard_normal(SIZE))
    x, _, report = solve(problem)
    np.testing.assert_allclose(STIFFNESS @ x, problem.load)
    assert (report.iterations, report.converged, len(problem.renewed_at)) == (1, True, 1)


def test_constraints_hold_and_their_multipliers_balance_the_residual():
    problem = Quartic(RNG.standard_normal(SIZE), target=np.array([1.0, -2.0]), cubic=0.5)
    x, multipliers, report = solve(problem)
    assert report.converged
    np.testing.assert_allclose(ROWS @ x, problem.target, atol=1e-12)
    np.testing.assert_allclose(problem.residual(x)[0] + ROWS.T @ multipliers, 0.0, atol=1e-9)


def test_a_poor_factor_is_made_up_for_and_what_was_learnt_serves_the_next_step(monkeypatch):
    """P is wrong in a few directions only; without pairs each iteration would leave 0.9 of the error there."""
    monkeypatch.setattr(lbfgs, "PATIENCE", 100)
    bfgs, poor = lbfgs.LaggedBfgs(), STIFFNESS + POOR
    first = solve(Quartic(RNG.standard_normal(SIZE), factor=poor), bfgs)[2]
    assert first.converged
    assert first.iterations <= lbfgs.MAXIMUM_ITERATIONS
    second = solve(Quartic(RNG.standard_normal(SIZE), factor=poor), bfgs)[2]
    assert second.converged
    assert second.iterations < first.iterations


def test_the_pairs_invert_a_quadratic_along_what_they_have_seen():
    problem, pairs = Quartic(np.zeros(SIZE), factor=np.eye(SIZE)), lbfgs.Pairs()
    s = RNG.standard_normal(SIZE)
    pairs.add(s, STIFFNESS @ s)
    direction, _ = pairs.direction(problem, STIFFNESS @ s, np.zeros(0))
    np.testing.assert_allclose(direction, s)


def test_a_pair_of_negative_curvature_is_not_taken():
    pairs = lbfgs.Pairs()
    pairs.add(np.ones(3), -np.ones(3))
    assert len(pairs) == 0


def test_only_the_newest_pairs_are_kept():
    pairs = lbfgs.Pairs()
    for n in range(lbfgs.MEMORY + 5):
        pairs.add(np.full(2, 1.0 + n), np.ones(2))
    assert len(pairs) == lbfgs.MEMORY


def test_a_stale_factor_is_renewed_within_the_step(monkeypatch):
    monkeypatch.setattr(lbfgs, "PATIENCE", 4)
    monkeypatch.setattr(lbfgs, "FACTOR_COST", 1)
    problem = Quartic(3.0 * RNG.standard_normal(SIZE), cubic=0.02, factor=STIFFNESS + POOR)
    x, _, report = solve(problem)
    assert report.converged
    assert 1 <= len(problem.renewed_at) <= lbfgs.RENEWALS_IN_STEP
    np.testing.assert_allclose(problem.residual(x)[0], 0.0, atol=1e-9)


def test_a_residual_that_grows_calls_for_a_factor_of_the_last_good_x():
    problem = Quartic(RNG.standard_normal(SIZE), factor=1e-3 * STIFFNESS)
    _, _, report = solve(problem, x=np.zeros(SIZE))
    assert report.converged
    assert len(problem.renewed_at) >= 1


def test_a_factor_that_wastes_iterations_is_renewed_before_the_next_step(monkeypatch):
    monkeypatch.setattr(lbfgs, "PATIENCE", 100)
    bfgs, problem = lbfgs.LaggedBfgs(), Quartic(RNG.standard_normal(SIZE))
    assert solve(problem, bfgs)[2].iterations == 1
    problem.P = STIFFNESS + POOR
    wasted = 0
    while len(problem.renewed_at) == 1:
        problem.load = RNG.standard_normal(SIZE)
        bfgs._pairs.forget()
        iterations = solve(problem, bfgs)[2].iterations
        before, wasted = wasted, wasted + iterations - lbfgs.FRESH_ITERATIONS
    assert before >= lbfgs.FACTOR_COST
    assert iterations == 1


def test_a_residual_that_is_not_finite_is_reported():
    problem = Quartic(np.full(SIZE, np.nan), factor=STIFFNESS)
    assert not solve(problem)[2].converged
