"""Volume correction in the subspaces: sensors, drift, equality with full space, batches; and on states."""

from dataclasses import replace

import numpy as np
import pytest
import warp as wp

from lingual.model import TongueModel
from lingual.model.volume import ElementVolumes
from lingual.model.volume_correction import VolumeCorrection
from lingual.model.volume_polynomial import volume_coefficients
from lingual.model.volume_pressure import PressureSubspace
from lingual.precompute.pressure_subspace import PressureSettings, build_pressure_subspace
from lingual.precompute.reduction import all_element_model
from lingual.solver.reduced import SolverReduced
from lingual.solver.volume_full_space import VolumeFullSpace
from lingual.solver.volume_subspace import SubspaceVolume

ALL = np.ones((4, 3), dtype=bool)
PLANAR = np.tile([True, False, True], (4, 1))


@pytest.fixture(scope="module")
def model(small_tongue):
    return all_element_model(small_tongue, 5)


@pytest.fixture(scope="module")
def subspace(model, tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LINGUAL_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield build_pressure_subspace(model, PressureSettings(key_frame_count=24))


@pytest.fixture(params=["cpu", pytest.param("cuda:0", marks=pytest.mark.gpu)])
def device(request) -> str:
    if request.param != "cpu" and not wp.is_cuda_available():
        pytest.skip("there is no CUDA device")
    return request.param


def coordinates_of(model, seed: int, tongues: int = 1, size: float = 0.15) -> np.ndarray:
    """Projections of random quadratic displacements that vanish where the tongue is held: strains of about `size`."""
    X = model.tongue.mesh.nodes
    s, y = X[:, :1] / X[:, 0].max(), (X - X.mean(axis=0)) / X[:, 0].max()
    shapes = np.hstack([s, s**2, s * y])
    random = np.random.default_rng(seed).standard_normal((5, 3, tongues))
    displacement = size * X[:, 0].max() * np.einsum("na,ait->nit", shapes, random) / 3.0
    return np.einsum("nk,n,nit->kit", model.basis, model.tongue.node_masses, displacement)


def corrected(volume, coordinates, velocity=None, device="cpu", dtype=wp.float64):
    """Coordinates, or the velocity when there is one, after the correction."""
    q = wp.array(coordinates, dtype=dtype, device=device)
    v = wp.array(coordinates if velocity is None else velocity, dtype=dtype, device=device)
    stages = volume.bind_position(q) if velocity is None else volume.bind_velocity(v, q)
    for stage in stages:
        stage()
    return (q if velocity is None else v).numpy()


def drift(model, coordinates) -> float:
    elements = ElementVolumes(model.tongue.mesh, model.tongue.free_nodes)
    elements.set_positions(model.tongue.mesh.nodes + model.basis @ coordinates)
    return elements.volumes.sum() / model.tongue.mesh.volume - 1.0


@pytest.mark.parametrize("constrained", [ALL, PLANAR])
def test_drift_falls_and_sensors_stay(model, subspace, constrained):
    volume = SubspaceVolume(model, subspace, constrained)
    before = coordinates_of(model, 0)
    after = corrected(volume, before)
    again = corrected(volume, after)
    assert abs(drift(model, before[:, :, 0])) > 1e-3
    assert abs(drift(model, after[:, :, 0])) < 0.02 * abs(drift(model, before[:, :, 0]))
    assert abs(drift(model, again[:, :, 0])) < 1e-6
    moved = (model.sensor_rows @ (after - before)[:, :, 0])[constrained]
    assert np.abs(moved).max() < 1e-15


def test_rest_is_left_alone(model, subspace):
    rest = np.zeros((model.column_count, 3, 1))
    assert not corrected(SubspaceVolume(model, subspace, ALL), rest).any()


def test_rates_are_corrected_as_positions_are(model, subspace):
    volume = SubspaceVolume(model, subspace, ALL)
    q, v = coordinates_of(model, 1), coordinates_of(model, 2)
    after = corrected(volume, q, v)
    elements = ElementVolumes(model.tongue.mesh, model.tongue.free_nodes)
    elements.set_positions(model.tongue.mesh.nodes + model.basis @ q[:, :, 0])
    free_basis = model.basis[model.tongue.free_nodes]
    rates = [elements.divergence @ (free_basis @ values[:, :, 0]).ravel() for values in (v, after)]
    modal = [np.linalg.norm(subspace.basis.T @ rate) for rate in rates]
    assert abs(rates[1].sum()) < 1e-12 * np.abs(rates[0]).sum()
    assert modal[1] < 0.5 * modal[0]
    assert np.abs(model.sensor_rows @ (after - v)[:, :, 0]).max() < 1e-15


def test_a_corrected_rate_needs_no_correction(model, subspace):
    """Repeating it brings the rate to where the pressure modes see no divergence."""
    volume = SubspaceVolume(model, subspace, ALL, compliance_length=0.1)
    q, v = coordinates_of(model, 1, size=0.05), coordinates_of(model, 2)
    volume.refresh(q[:, :, 0])
    once = corrected(volume, q, v)
    many = once
    for _ in range(30):
        many = corrected(volume, q, many)
    assert np.linalg.norm(corrected(volume, q, many) - many) < 1e-2 * np.linalg.norm(once - v)


def everything(tongue: TongueModel):
    """A subspace that is all of the tongue's freedom, displacements and pressures alike."""
    exact = all_element_model(tongue, 5)
    free, mesh = tongue.free_nodes, tongue.mesh
    basis = np.zeros((mesh.node_count, len(free)))
    basis[free, np.arange(len(free))] = 1.0 / np.sqrt(tongue.node_masses[free])
    model = replace(exact, basis=basis)
    root = np.sqrt(mesh.volumes)
    pressure = PressureSubspace(
        np.diag(1.0 / root), np.diag(root), 0.0, volume_coefficients(mesh, basis), 0
    )
    return model, pressure


def test_equals_full_space_when_the_subspace_is_everything(block, tongue_of, monkeypatch):
    monkeypatch.setattr("lingual.model.volume_correction.TOLERANCE", 1e-9)
    tongue = tongue_of(block((0.06, 0.02, 0.02), (4, 2, 2)), {"TT": 44, "TB": 35})
    model, pressure = everything(tongue)
    constrained, length = np.ones((2, 3), dtype=bool), 0.01
    displacement = np.zeros_like(tongue.mesh.nodes)
    displacement[tongue.free_nodes] = 1e-5 * np.random.default_rng(3).standard_normal((len(tongue.free_nodes), 3))
    Q = displacement[tongue.free_nodes] * np.sqrt(tongue.node_masses[tongue.free_nodes])[:, None]
    volume = SubspaceVolume(model, pressure, constrained, compliance_length=length)
    q = wp.array(Q[:, :, None], dtype=wp.float64, device="cpu")
    for stage in volume.bind_position(q):
        stage()
    full = VolumeCorrection(tongue, constrained, length)
    reference = full.correct_positions(tongue.mesh.nodes + displacement, 1) - tongue.mesh.nodes
    moved, should = model.basis @ q.numpy()[:, :, 0] - displacement, reference - displacement
    assert np.linalg.norm(moved - should) < 0.01 * np.linalg.norm(should)


@pytest.mark.parametrize("precision_name", ["float64", "float32"])
def test_a_batch_equals_single_tongues(model, subspace, device, precision_name):
    dtype, tolerance = (wp.float64, 1e-12) if precision_name == "float64" else (wp.float32, 2e-4)
    q, v = coordinates_of(model, 4, 40), coordinates_of(model, 5, 40)
    batch = SubspaceVolume(model, subspace, PLANAR, 40, precision_name, device)
    single = SubspaceVolume(model, subspace, PLANAR)
    after, rate = corrected(batch, q, None, device, dtype), corrected(batch, q, v, device, dtype)
    for t in (0, 17, 39):
        one = slice(t, t + 1)
        change = corrected(single, q[:, :, one]) - q[:, :, one]
        rate_change = corrected(single, q[:, :, one], v[:, :, one]) - v[:, :, one]
        assert np.abs(after[:, :, one] - q[:, :, one] - change).max() < tolerance * np.abs(q).max()
        assert np.abs(rate[:, :, one] - v[:, :, one] - rate_change).max() < tolerance * np.abs(v).max()


def test_full_space_correction_of_a_reduced_state(model, control_of, advance):
    tongue = model.tongue
    solver = SolverReduced(model)
    control = control_of(tongue, {("TT", 2): 0.006, ("TB", 2): 0.006, ("TD", 2): 0.003})
    state = advance(solver, control, 0.01, steps=3)
    before = state.position.numpy().copy()
    sensors = tongue.sensors.positions(before)
    correction = VolumeFullSpace(tongue, control.sensor_constrained, model.basis)
    correction.correct(state)
    assert abs(correction.report.drift) < 5e-4 * 1e-2
    gaps = (tongue.sensors.positions(state.position.numpy()) - sensors)[control.sensor_constrained]
    assert np.abs(gaps).max() < 1e-12
    projected = model.basis @ state.coordinates.numpy()
    moved = state.position.numpy() - tongue.mesh.nodes
    residual = model.basis.T @ (tongue.node_masses[:, None] * (moved - projected))
    assert np.abs(residual).max() < 1e-14  # what the subspace cannot show is orthogonal to it
