"""Motion of both solvers against independent references: frequency, energy, order of accuracy."""

import numpy as np
import pytest

from lingual.precompute.reduction import all_element_model
from lingual.solver.full_space import SolverFullSpace
from lingual.solver.reduced import SolverReduced

SIDEWAYS = (0.0, -0.8, 0.0)


@pytest.fixture(scope="module")
def bar_solver(make_solver, bar):
    return make_solver(bar)


@pytest.fixture(scope="module")
def released(bar_solver, control_of, static):
    """The bar bent by about 10 mm, about to be let go."""
    return static(bar_solver, control_of(bar_solver.tongue, gravity=SIDEWAYS), load_steps=4)


def test_rest_is_stationary(solver, control_of, advance, displacement):
    state = advance(solver, control_of(solver.tongue), dt=0.01, steps=3)
    assert not displacement(solver, state).any()
    assert not state.velocity.numpy().any()
    assert state.time == pytest.approx(0.03)


def test_a_clamped_bar_rings_at_its_lowest_eigenfrequency(bar_solver, lowest_mode, control_of, advance):
    """Implicit Euler rings at atan(w h) / h and loses sqrt(1 + (w h)^2) of its amplitude each step."""
    mode = lowest_mode(bar_solver)
    dt = 2.0 * np.pi / mode.omega / 100.0
    amplitudes = [1.0]
    advance(
        bar_solver, control_of(bar_solver.tongue), dt, 90, mode.state(1.0),
        on_step=lambda state: amplitudes.append(mode.amplitude(state)),
    )  # fmt: skip
    q = np.array(amplitudes)
    before = np.flatnonzero(q[:-1] * q[1:] < 0)  # a quarter and three quarters of a period
    crossings = (before + q[before] / (q[before] - q[before + 1])) * dt
    assert len(crossings) == 2
    measured = np.pi / (crossings[1] - crossings[0])
    assert measured == pytest.approx(mode.omega, rel=2e-3)
    assert measured == pytest.approx(np.arctan(mode.omega * dt) / dt, rel=2e-4)
    assert abs(q[-1]) <= (1.0 + (mode.omega * dt) ** 2) ** -45.0 * 1.001


def test_the_subspace_rings_a_little_higher_than_the_whole_bar(bar, lowest_mode):
    """Rayleigh and Ritz: a subspace can only raise the lowest frequency."""
    full = lowest_mode(SolverFullSpace(bar)).omega
    reduced = lowest_mode(SolverReduced(all_element_model(bar, 5))).omega
    assert full < reduced < 1.03 * full


def test_a_small_step_is_that_of_a_rayleigh_damped_oscillator(solver, lowest_mode, control_of, advance):
    """(q1 - q0 - h v0) / h^2 + (a + b w^2) (q1 - q0) / h + w^2 q1 = 0 with Rayleigh's a and b."""
    mode, material = lowest_mode(solver), solver.tongue.material
    q0, v0, h = 1.0, -30.0, 0.01
    damping = (material.damping_mass + material.damping_stiffness * mode.omega**2) / h
    expected = (q0 * (1.0 / h**2 + damping) + v0 / h) / (1.0 / h**2 + damping + mode.omega**2)
    state = advance(solver, control_of(solver.tongue), h, state=mode.state(q0, v0))
    assert mode.amplitude(state) == pytest.approx(expected, rel=1e-4)


def test_without_load_the_total_energy_never_grows(bar_solver, released, control_of, advance, total_energy):
    energy = total_energy(bar_solver)
    values = [energy(released)]
    advance(bar_solver, control_of(bar_solver.tongue), 0.01, 40, released, lambda state: values.append(energy(state)))
    assert np.all(np.diff(values) <= 1e-9 * values[0])
    assert 0.0 < values[-1] < 0.9 * values[0]


def test_the_damped_tongue_comes_back_to_rest(solver, control_of, advance, static, displacement):
    raised = static(solver, control_of(solver.tongue, {("TT", 2): 0.008, ("TD", 2): 0.003}))
    settled = advance(solver, control_of(solver.tongue), 0.01, 150, raised)
    assert abs(displacement(solver, settled)).max() < 0.02 * abs(displacement(solver, raised)).max()


def test_implicit_euler_is_first_order_in_the_time_step(bar_solver, released, control_of, advance, displacement):
    """The bent bar is let go for a fifth of its period; halving the step halves the error."""
    control, duration = control_of(bar_solver.tongue), 0.04
    ends = [
        displacement(bar_solver, advance(bar_solver, control, duration / steps, steps, released))
        for steps in (16, 32, 64)
    ]
    order = np.log2(np.linalg.norm(ends[0] - ends[1]) / np.linalg.norm(ends[1] - ends[2]))
    assert order == pytest.approx(1.0, abs=0.1)
