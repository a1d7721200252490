"""The full-space solver's two methods against each other, its further nodal terms, and rough treatment."""

import numpy as np
import pytest
import warp as wp

from lingual.solver import full_space
from lingual.solver.full_space import SolverFullSpace

STEP = 0.01
SPEECH = {("TT", 0): -0.003, ("TT", 2): 0.006, ("TB", 2): 0.005, ("TD", 0): -0.002, ("TR", 0): 0.001}


@pytest.mark.parametrize("device", ["cpu", pytest.param("cuda:0", marks=pytest.mark.gpu)])
def test_conjugate_gradients_on_a_device_give_the_same_steps(small_tongue, control_of, advance, device):
    if device != "cpu" and not wp.is_cuda_available():
        pytest.skip("there is no CUDA device")
    factored = SolverFullSpace(small_tongue)
    iterated = SolverFullSpace(small_tongue, device=device, method="conjugate-gradients")
    for imposed in ({}, SPEECH, {("TD", 0): 0.002}):
        control = control_of(small_tongue, imposed, (0.0, 0.0, -9.81))
        a, b = (advance(solver, control, STEP, 4) for solver in (factored, iterated))
        assert str(b.position.device) == device
        np.testing.assert_allclose(b.position.numpy(), a.position.numpy(), rtol=0, atol=1e-9)
        np.testing.assert_allclose(b.velocity.numpy(), a.velocity.numpy(), rtol=0, atol=1e-7)
        np.testing.assert_allclose(b.sensor_force.numpy(), a.sensor_force.numpy(), rtol=0, atol=1e-6)


def test_newtons_method_takes_over_where_the_first_method_fails(small_tongue, control_of, advance, monkeypatch):
    control = control_of(small_tongue, SPEECH)
    expected = advance(SolverFullSpace(small_tongue), control, STEP)
    solver = SolverFullSpace(small_tongue)

    def fail(problem, x, report, tolerance):
        report.converged = False
        return x, np.zeros(len(SPEECH))

    monkeypatch.setattr(solver._bfgs, "solve_step", fail)
    taken = advance(solver, control, STEP)
    np.testing.assert_allclose(taken.position.numpy(), expected.position.numpy(), rtol=0, atol=1e-9)


def test_two_runs_give_the_same_bits(small_tongue, control_of, advance):
    control = control_of(small_tongue, SPEECH)
    first, again = (advance(SolverFullSpace(small_tongue), control, STEP, 6) for _ in range(2))
    np.testing.assert_array_equal(first.position.numpy(), again.position.numpy())


class Springs:
    """Linear springs to the rest places of some nodes; a stiffness [N/m] and a constant force [N] each."""

    def __init__(self, nodes, stiffness=0.0, force=(0.0, 0.0, 0.0)) -> None:
        self.nodes, self._stiffness, self._force = np.asarray(nodes), stiffness, np.array(force)
        self.begun = []

    def begin_step(self, displacement, control, dt):
        self.begun.append((displacement.copy(), dt))

    def force(self, displacement):
        return self._stiffness * displacement - self._force

    def stiffness(self, displacement):
        return np.tile(self._stiffness * np.eye(3), (len(self.nodes), 1, 1))


@pytest.mark.parametrize("method", ["factor", "conjugate-gradients"])
def test_a_spring_acts_like_the_force_it_exerts(small_tongue, control_of, static, displacement, method):
    tip = small_tongue.free_nodes[-3:]
    control = control_of(small_tongue, gravity=(0.0, 0.0, -0.5))
    sprung = SolverFullSpace(small_tongue, terms=(Springs(tip, 2.0),), method=method)
    free = displacement(SolverFullSpace(small_tongue), static(SolverFullSpace(small_tongue), control))
    held = displacement(sprung, static(sprung, control))
    assert np.linalg.norm(held[tip]) < 0.9 * np.linalg.norm(free[tip])
    pushed = tuple(Springs([n], force=-2.0 * held[n]) for n in tip)
    same = SolverFullSpace(small_tongue, terms=pushed)
    np.testing.assert_allclose(displacement(same, static(same, control)), held, rtol=0, atol=1e-9)


def test_terms_see_the_start_of_each_step_and_held_nodes_are_ignored(small_tongue, control_of, advance):
    nodes = np.r_[small_tongue.fixed_nodes[:2], small_tongue.free_nodes[-2:]]
    spring = Springs(nodes, 5.0, (0.0, 0.0, 0.01))
    state = advance(SolverFullSpace(small_tongue, terms=(spring,)), control_of(small_tongue), STEP, 2)
    moved = state.position.numpy() - small_tongue.mesh.nodes
    (first, dt), (second, _) = spring.begun
    assert dt == STEP
    assert not first.any()
    assert not second[:2].any()
    assert second[2:].any()
    np.testing.assert_array_equal(moved[nodes[:2]], 0.0)
    assert moved[nodes[2:], 2].min() > second[2:, 2].max() > 0.0


def test_a_tip_pulled_by_30_mm_and_let_go_comes_back(small_tongue, control_of, advance, displacement):
    solver = SolverFullSpace(small_tongue)
    state = solver.new_state()
    for n in range(1, 11):
        state = advance(solver, control_of(small_tongue, {("TT", 2): 0.003 * n}), STEP, state=state)
    assert displacement(solver, state).max() > 0.0295
    far = []
    advance(
        solver, control_of(small_tongue), STEP, 60, state,
        on_step=lambda s: far.append(abs(displacement(solver, s)).max()),
    )  # fmt: skip
    assert far[-1] < 0.5 * far[0]
    assert max(far) < 0.035


def test_a_factor_that_cannot_be_made_leaves_a_report(small_tongue, control_of, monkeypatch):
    def refuse(self, blocks):
        raise np.linalg.LinAlgError

    monkeypatch.setattr(full_space.MultifrontalCholesky, "factorise", refuse)
    solver = SolverFullSpace(small_tongue)
    solver.step(solver.new_state(), solver.new_state(), control_of(small_tongue, SPEECH), STEP)
    assert not solver.report.converged
