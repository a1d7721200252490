"""Solvers with full-space volume correction after each step: volume kept, sensors where they were, states whole."""

import numpy as np
import pytest

from lingual.model import Control
from lingual.precompute.modes import build_modal_model
from lingual.precompute.reduction import all_element_model
from lingual.solver.full_space import SolverFullSpace
from lingual.solver.modal_warping import SolverModalWarping
from lingual.solver.reduced import SolverReduced
from lingual.solver.volume_corrected import SolverVolumeCorrected

STEP = 0.01
RAISED = {("TT", 2): 0.006, ("TB", 2): 0.006, ("TD", 2): 0.005, ("TR", 2): 0.003}
NAMES = ("full", "reduced float64", "reduced float32", "modal-warping")


@pytest.fixture(scope="module")
def bare(small_tongue, tmp_path_factory):
    """Function name -> a new solver of the small tongue that lets its volume drift."""
    model = all_element_model(small_tongue, 5)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LINGUAL_CACHE", str(tmp_path_factory.mktemp("cache")))
        modal = build_modal_model(small_tongue, 60)
    makers = {
        "full": lambda: SolverFullSpace(small_tongue),
        "reduced float64": lambda: SolverReduced(model),
        "reduced float32": lambda: SolverReduced(model, "float32", 1e-5),
        "modal-warping": lambda: SolverModalWarping(modal, "float32"),
    }
    return lambda name: makers[name]()


@pytest.fixture(params=NAMES)
def name(request) -> str:
    return request.param


def raise_tongue(solver, control: Control, steps: int = 4):
    """The state after a few steps in which the targets move to those of the control."""
    rest = solver.tongue.sensor_rest_positions
    state, spare = solver.new_state(), solver.new_state()
    for n in range(1, steps + 1):
        part = Control(rest + n / steps * (control.sensor_targets - rest), control.sensor_constrained)
        solver.step(state, spare, part, STEP)
        assert solver.report.converged
        state, spare = spare, state
    return state


def volume_change(tongue, state) -> float:
    x = state.position.numpy().astype(float)[tongue.mesh.tets]
    return np.linalg.det(x[:, 1:] - x[:, :1]).sum() / np.linalg.det(_edges(tongue)).sum() - 1.0


def _edges(tongue) -> np.ndarray:
    x = tongue.mesh.nodes[tongue.mesh.tets]
    return x[:, 1:] - x[:, :1]


def test_volume_is_kept_and_the_sensors_stay_on_their_targets(bare, name, small_tongue, control_of):
    control = control_of(small_tongue, RAISED)
    drifted = raise_tongue(bare(name), control)
    kept = raise_tongue(SolverVolumeCorrected(bare(name)), control)
    assert abs(volume_change(small_tongue, drifted)) > 3e-4
    assert abs(volume_change(small_tongue, kept)) < 2e-5
    gap = small_tongue.sensors.positions(kept.position.numpy().astype(float)) - control.sensor_targets
    assert abs(gap[control.sensor_constrained]).max() < 1e-6
    fixed = small_tongue.fixed_nodes
    np.testing.assert_allclose(kept.position.numpy()[fixed], small_tongue.mesh.nodes[fixed], rtol=0, atol=1e-9)


def test_velocities_lose_their_divergence(bare, name, small_tongue, control_of):
    """The volume's rate, by moving the nodes a little along their velocity."""

    def rate(state) -> float:
        x, v = (a.numpy().astype(float) for a in (state.position, state.velocity))
        tets = small_tongue.mesh.tets
        volumes = [np.linalg.det((x + s * v)[tets][:, 1:] - (x + s * v)[tets][:, :1]).sum() for s in (1e-6, -1e-6)]
        return (volumes[0] - volumes[1]) / 2e-6 / np.linalg.det(_edges(small_tongue)).sum()

    control = control_of(small_tongue, RAISED)
    drifted = raise_tongue(bare(name), control)
    kept = raise_tongue(SolverVolumeCorrected(bare(name)), control)
    assert abs(rate(drifted)) > 0.02
    assert abs(rate(kept)) < 0.01 * abs(rate(drifted))


def test_rest_is_left_alone(bare, name, small_tongue, control_of):
    solver = SolverVolumeCorrected(bare(name))
    state = raise_tongue(solver, control_of(small_tongue, {("TT", 2): 0.0}))
    np.testing.assert_allclose(state.position.numpy(), small_tongue.mesh.nodes, rtol=0, atol=1e-8)
    assert abs(state.velocity.numpy()).max() < 1e-6


@pytest.mark.parametrize("precision", ["float64", "float32"])
def test_reduced_coordinates_follow_the_corrected_shape(bare, precision, small_tongue, control_of):
    """Up to what the subspace cannot show, which is orthogonal to it; the next step starts there."""
    bare_solver = bare(f"reduced {precision}")
    basis, masses = bare_solver.model.basis, small_tongue.node_masses[:, None]
    state = raise_tongue(SolverVolumeCorrected(bare_solver), control_of(small_tongue, RAISED))
    moved = state.position.numpy().astype(float) - small_tongue.mesh.nodes
    rest_of_it = moved - basis @ state.coordinates.numpy().astype(float)
    assert abs(rest_of_it).max() > 1e-5
    assert abs(basis.T @ (masses * rest_of_it)).max() < 1e-6 * abs(basis.T @ (masses * moved)).max()


def test_each_set_of_imposed_coordinates_has_its_own_correction(bare, small_tongue, control_of):
    """One solver, first with tip and dorsum held, then with the tip alone."""
    solver = SolverVolumeCorrected(bare("full"))
    state, after = raise_tongue(solver, control_of(small_tongue, RAISED)), solver.new_state()
    tip = control_of(small_tongue, {("TT", 2): 0.008})
    solver.step(state, after, tip, STEP)
    place = tip.sensor_constrained
    moved = small_tongue.sensors.positions(after.position.numpy()) - tip.sensor_targets
    assert abs(moved[place]).max() < 1e-9
    assert abs(volume_change(small_tongue, after)) < 2e-5


def test_it_answers_for_the_solver_inside(bare, name, small_tongue):
    inside = bare(name)
    solver = SolverVolumeCorrected(inside)
    assert (solver.name, solver.dof_count, solver.tongue) == (inside.name, inside.dof_count, small_tongue)
    assert (solver.volume_mode, solver.contact_point_count) == ("full", inside.contact_point_count)
    assert solver.report is inside.report


def test_positions_that_are_not_finite_are_passed_on(bare, small_tongue, control_of):
    """The session decides what becomes of a step that failed."""
    inside = bare("full")

    def fail(state_in, state_out, control, dt):
        state_out.position.numpy()[:] = np.nan
        inside.report.converged = False

    inside.step = fail
    solver = SolverVolumeCorrected(inside)
    state = solver.new_state()
    solver.step(solver.new_state(), state, control_of(small_tongue, RAISED), STEP)
    assert np.isnan(state.position.numpy()).all()
    assert not solver.report.converged
