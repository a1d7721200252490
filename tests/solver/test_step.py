"""What one step promises whatever it computes: the state it leaves, its report, odd controls."""

from dataclasses import replace

import numpy as np
import pytest

from lingual.model import LingualError
from lingual.precompute.reduction import all_element_model
from lingual.solver.reduced import SolverReduced

STEP = 0.01
ARRAYS = ("position", "velocity", "coordinates", "coordinate_velocity", "sensor_force")
SPEECH = {("TT", 0): -0.003, ("TT", 2): 0.006, ("TB", 2): 0.005, ("TD", 0): -0.002, ("TR", 0): 0.001}


def test_a_step_leaves_its_input_state_alone(solver, control_of, advance):
    start = advance(solver, control_of(solver.tongue, SPEECH), STEP)
    before = {name: getattr(start, name).numpy().copy() for name in ARRAYS}
    solver.step(start, solver.new_state(), control_of(solver.tongue, {}, (0.0, 0.0, -9.81)), STEP)
    assert start.time == STEP
    for name in ARRAYS:
        np.testing.assert_array_equal(getattr(start, name).numpy(), before[name])


def test_velocity_is_the_change_of_position_over_the_step(solver, control_of, advance):
    start = advance(solver, control_of(solver.tongue, SPEECH), STEP)
    end = advance(solver, control_of(solver.tongue, SPEECH), STEP, state=start)
    change = (end.position.numpy() - start.position.numpy()) / STEP
    np.testing.assert_allclose(end.velocity.numpy(), change, rtol=0, atol=1e-10)
    assert end.time == pytest.approx(2 * STEP)


def test_sensor_targets_are_met_to_a_nanometre_within_one_step(solver, control_of, advance):
    state = advance(solver, control_of(solver.tongue, SPEECH), STEP)
    moved = solver.tongue.sensors.positions(state.position.numpy()) - solver.tongue.sensor_rest_positions
    errors = [moved[solver.tongue.sensors.names.index(name), axis] - v for (name, axis), v in SPEECH.items()]
    assert max(map(abs, errors)) < 1e-9
    assert 1 < solver.report.iterations <= 40
    assert solver.report.residual <= solver.tolerance


def test_a_sensor_that_jumps_by_20_mm_does_not_blow_the_tongue_up(solver, control_of, advance, displacement):
    far = []
    advance(
        solver, control_of(solver.tongue, {("TT", 0): 0.0, ("TT", 2): 0.02}), STEP, 10,
        on_step=lambda state: far.append(abs(displacement(solver, state)).max()),
    )  # fmt: skip
    assert max(far) < 0.025
    assert far[-1] == pytest.approx(far[-2], rel=0.05)


def test_other_coordinates_may_be_imposed_from_step_to_step(solver, control_of, advance):
    """Channels drop out and come back; the answer is that of a solver that has seen nothing else."""
    first = advance(solver, control_of(solver.tongue, {("TT", 2): 0.004}), STEP)
    second_control = control_of(solver.tongue, {("TD", 0): 0.002, ("TR", 2): 0.001})
    second = advance(solver, second_control, STEP, state=first)
    force = second.sensor_force.numpy()
    assert force[0, 2] == 0.0
    assert abs(force[2, 0]) > 1e-6
    advance(solver, control_of(solver.tongue), STEP, state=second)
    again = advance(solver, second_control, STEP, state=first)
    np.testing.assert_allclose(again.position.numpy(), second.position.numpy(), rtol=0, atol=1e-9)


def test_a_control_may_be_overwritten_and_used_again(solver, control_of, advance):
    control = control_of(solver.tongue, {("TT", 2): 0.004})
    first = advance(solver, control, STEP)
    control.sensor_targets[0, 2] -= 0.002
    control.sensor_constrained[2, 0] = True
    second = advance(solver, control, STEP, state=first)
    assert second.position.numpy()[solver.tongue.sensors.footprint(0)[0], 2] == pytest.approx(0.022, abs=1e-9)
    assert abs(second.sensor_force.numpy()[2, 0]) > 1e-6


def test_a_target_that_is_not_finite_is_named(solver, control_of):
    control = control_of(solver.tongue, {("TB", 2): np.nan})
    with pytest.raises(LingualError, match="sensor TB along z is not a finite number"):
        solver.step(solver.new_state(), solver.new_state(), control, STEP)


def test_a_target_that_is_not_imposed_may_be_anything(solver, control_of, advance, displacement):
    control = control_of(solver.tongue)
    control.sensor_targets[:] = np.nan
    assert not displacement(solver, advance(solver, control, STEP)).any()


def test_two_sensors_on_one_node_are_reported_and_the_next_step_still_runs(make_solver, small_tongue, control_of):
    """Contradicting rows have no solution; that is not to end the session."""
    sensors = small_tongue.sensors
    doubled = replace(small_tongue, sensors=replace(sensors, weights=sensors.weights[[0, 0, 2, 3]]))
    model = all_element_model(small_tongue, 5)
    solver = make_solver(small_tongue)
    solver = SolverReduced(replace(model, tongue=doubled)) if solver.name == "reduced" else make_solver(doubled)
    both = control_of(doubled, {("TT", 2): 0.001, ("TB", 2): 0.002})
    for _ in range(2):
        solver.step(solver.new_state(), solver.new_state(), both, STEP)
        assert not solver.report.converged
    solver.step(solver.new_state(), solver.new_state(), control_of(doubled, {("TT", 2): 0.001}), STEP)
    assert solver.report.converged


def test_single_precision_follows_double(small_tongue, control_of, advance):
    model = all_element_model(small_tongue, 5)
    control = control_of(small_tongue, SPEECH)
    double = advance(SolverReduced(model), control, STEP, 5)
    single = advance(SolverReduced(model, "float32", tolerance=1e-3), control, STEP, 5)
    assert single.position.numpy().dtype == np.float32
    np.testing.assert_allclose(single.position.numpy(), double.position.numpy(), rtol=0, atol=2e-5)
