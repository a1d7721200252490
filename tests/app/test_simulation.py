"""The simulation keeps every frame, measures it right, and survives steps that do not converge."""

import logging

import numpy as np
import pytest

from lingual.app.report import simulation_report
from lingual.app.simulation import Simulation
from lingual.model.tet_mesh import signed_volumes
from lingual.solver.full_space import SolverFullSpace

STALLS_AT = 3


@pytest.fixture(scope="module")
def simulation(small_tongue, trajectory):
    simulation = Simulation(SolverFullSpace(small_tongue), trajectory)
    simulation.run()
    return simulation


@pytest.fixture(scope="module")
def deformed(simulation, trajectory):
    """Nodes of every frame, (8, node_count, 3), as the history holds them in single precision."""
    return np.array([simulation.history.sample(t).nodes for t in trajectory.time], dtype=np.float64)


def test_the_history_is_complete(simulation, trajectory, small_tongue):
    history = simulation.history
    np.testing.assert_array_equal(history.time, trajectory.time)
    assert simulation.unconverged_frames == []
    sample = history.sample(trajectory.time[4])
    np.testing.assert_array_equal(sample.sensor_targets, trajectory.positions[4])
    np.testing.assert_array_equal(sample.jaw_translation, trajectory.jaw_translation[4])
    np.testing.assert_allclose(sample.sensors, small_tongue.sensors.positions(sample.nodes), rtol=0, atol=1e-8)


def test_every_measured_coordinate_is_on_its_target_and_the_others_are_free(simulation, trajectory):
    sensors = np.array([simulation.history.sample(t).sensors for t in trajectory.time])
    gap = sensors - trajectory.positions
    assert abs(gap[:, trajectory.measured]).max() < 1e-9
    assert abs(gap[..., 1]).max() > 1e-8


def test_volume_and_det_f_are_those_of_the_deformed_elements(simulation, deformed, small_tongue):
    mesh, history = small_tongue.mesh, simulation.history
    volumes = np.array([signed_volumes(nodes, mesh.tets) for nodes in deformed])
    np.testing.assert_allclose(history.scalar("volume_ratio"), volumes.sum(axis=1) / mesh.volume, atol=1e-5)
    np.testing.assert_allclose(history.scalar("det_f_min"), (volumes / mesh.volumes).min(axis=1), atol=1e-4)
    assert 0.5 < history.scalar("det_f_min").min() < 0.99


def test_strain_energy_is_stvk_of_the_deformed_elements(simulation, deformed, small_tongue):
    mesh, material = small_tongue.mesh, small_tongue.material
    F = np.einsum("teai,eaj->teij", deformed[:, mesh.tets], mesh.shape_gradients)
    E = 0.5 * (np.swapaxes(F, -1, -2) @ F - np.eye(3))
    trace = np.trace(E, axis1=-2, axis2=-1)
    density = material.lame_mu * np.sum(E**2, axis=(-1, -2)) + 0.5 * material.lame_lambda * trace**2
    expected = density @ mesh.volumes
    np.testing.assert_allclose(simulation.history.scalar("strain_energy"), expected, rtol=1e-3, atol=1e-9)
    assert expected.max() > 1e-5


def test_the_report_states_what_the_history_holds(simulation, trajectory, small_tongue):
    report, history = simulation_report(simulation, "block"), simulation.history
    step_ms = history.scalar("step_ms")
    assert report["solver"] == "full"
    assert report["mesh"] == "block"
    assert report["source"] == "movement"
    assert (report["node_count"], report["tet_count"], report["dof_count"]) == (180, 576, 3 * 160)
    assert report["frame_count"] == 8
    assert report["step_ms"] == {"median": np.median(step_ms), "p95": np.percentile(step_ms, 95)}
    assert report["frames_per_second"] == pytest.approx(8e3 / step_ms.sum())
    assert report["volume_drift_max"] == abs(history.scalar("volume_ratio") - 1.0).max()
    assert report["det_f_min"] == history.scalar("det_f_min").min()
    assert report["sensor_error_mm_max"] == history.scalar("sensor_error_mm").max() < 1e-6
    assert report["newton_iterations_mean"] == history.scalar("newton_iterations").mean() >= 2.0
    assert report["inverted_tet_count_max"] == 0
    assert report["unconverged_frames"] == []
    assert report["halved_frame_count"] == 0


def test_an_inverted_element_and_a_missed_target_are_counted(moving_solver, trajectory, small_tongue):
    solver = moving_solver()
    simulation = Simulation(solver, trajectory)

    def crush(state_in, state_out, control, dt):
        state_out.position.numpy()[:] = small_tongue.mesh.nodes * [1.0, 1.0, -1.0]
        solver.report.converged = True

    solver.step = crush
    simulation.run()
    report = simulation_report(simulation, "block")
    assert report["inverted_tet_count_max"] == 576
    assert report["det_f_min"] == pytest.approx(-1.0)
    assert report["volume_drift_max"] == pytest.approx(2.0)
    lifted = 1e3 * (trajectory.positions[:, 0, 2].max() - small_tongue.sensor_rest_positions[0, 2])
    assert report["sensor_error_mm_max"] == pytest.approx(40.0 + lifted)  # the top is 20 mm low, not high


def test_a_report_before_the_first_frame_is_possible(moving_solver, trajectory):
    report = simulation_report(Simulation(moving_solver(), trajectory), "block")
    assert report["frame_count"] == 0
    assert report["det_f_min"] is None


def test_a_run_that_is_stopped_goes_on_where_it_was(moving_solver, trajectory):
    simulation = Simulation(moving_solver(), trajectory)
    simulation.run(should_stop=lambda: simulation.history.frame_count == 3)
    assert simulation.history.frame_count == 3
    frames = []
    simulation.run(on_frame=frames.append)
    assert frames == [3, 4, 5, 6, 7]


def stalls(smallest: float):
    """Only steps up to `smallest` converge on the way to the frame STALLS_AT, any elsewhere."""
    return lambda time: smallest if 0.0201 < time < 0.0301 else np.inf


@pytest.mark.parametrize(("smallest", "substeps"), [(0.005, 2), (0.0025, 4), (0.00125, 8)])
def test_a_step_that_does_not_converge_is_retried_with_halved_steps(moving_solver, trajectory, smallest, substeps):
    solver = moving_solver(stalls(smallest))
    simulation = Simulation(solver, trajectory)
    simulation.run()
    assert simulation.unconverged_frames == []
    assert simulation.history.scalar("substeps").tolist() == [1, 1, 1, substeps, 1, 1, 1, 1]
    assert simulation_report(simulation, "block")["halved_frame_count"] == 1
    last = solver.steps[-4 - substeps : -4]  # the attempt that succeeded, before the four frames after it
    np.testing.assert_allclose([dt for dt, _ in last], 0.01 / substeps)
    targets = np.array([target for _, target in last])
    path = np.linspace(trajectory.positions[2, 0], trajectory.positions[3, 0], substeps + 1)[1:]
    np.testing.assert_allclose(targets, path, rtol=0, atol=1e-15)
    tried = simulation.history.scalar("newton_iterations")[STALLS_AT]
    assert tried > 3 * substeps  # the failed attempts are counted too


@pytest.mark.parametrize("spoils", ["nearest", "nan"])
def test_a_step_that_never_converges_is_reported_and_the_session_goes_on(moving_solver, trajectory, spoils, caplog):
    simulation = Simulation(moving_solver(stalls(0.0), spoils), trajectory)
    with caplog.at_level(logging.WARNING):
        simulation.run()
    assert simulation.history.frame_count == 8
    assert simulation.unconverged_frames == [STALLS_AT]
    assert simulation.history.scalar("converged").tolist() == [1, 1, 1, 0, 1, 1, 1, 1]
    (message,) = caplog.messages
    assert "Frame 3 (0.03 s) did not converge" in message
    nodes = np.array([simulation.history.sample(t).nodes for t in trajectory.time])
    assert np.isfinite(nodes).all()
    if spoils == "nan":
        np.testing.assert_array_equal(nodes[STALLS_AT], nodes[STALLS_AT - 1])
    assert simulation_report(simulation, "block")["unconverged_frames"] == [STALLS_AT]


def test_a_frame_whose_first_substep_fails_has_not_converged_though_its_last_one_does(moving_solver, trajectory):
    def largest_step(time: float) -> float:
        return 0.0 if 0.0201 < time < 0.0259 else 0.005

    simulation = Simulation(moving_solver(largest_step), trajectory.head(4))
    simulation.run()
    assert simulation.unconverged_frames == [STALLS_AT]


def test_the_first_frame_is_reached_from_rest_in_one_ordinary_step(moving_solver, trajectory):
    solver = moving_solver()
    simulation = Simulation(solver, trajectory.head(1))
    simulation.run()
    assert [dt for dt, _ in solver.steps] == [0.01]
    assert simulation.history.time.tolist() == [0.0]
