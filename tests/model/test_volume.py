"""Element volumes, the divergence and the whole volume's polynomial."""

import numpy as np
import pytest
import warp as wp

from lingual.model.reduced_model import gradient_operator
from lingual.model.tet_mesh import signed_volumes
from lingual.model.volume import ElementVolumes
from lingual.model.volume_correction import VolumeCorrection
from lingual.model.volume_polynomial import TotalVolume, volume_coefficients
from lingual.model.volume_pressure import excess_jacobian

ALL = np.ones((4, 3), dtype=bool)


@pytest.fixture(scope="module")
def bent(small_tongue):
    """Node positions of a bent and squeezed small tongue: nothing moves where it is held, x = 0."""
    X = small_tongue.mesh.nodes
    s = X[:, :1] / X[:, 0].max()
    return X + s**2 * np.array([0.0, 0.004, 0.012]) - 0.08 * s * (X - X.mean(axis=0))


@pytest.fixture(scope="module")
def elements(small_tongue):
    return ElementVolumes(small_tongue.mesh, small_tongue.free_nodes)


@pytest.fixture(scope="module")
def basis(small_tongue):
    """Twelve smooth functions that vanish where the tongue is held, (node_count, 12)."""
    X = small_tongue.mesh.nodes / 0.06
    powers = [(a, b, c) for a in (1, 2, 3) for b in (0, 1) for c in (0, 1)]
    return np.stack([X[:, 0] ** a * X[:, 1] ** b * X[:, 2] ** c for a, b, c in powers], axis=1)


def test_volumes_are_those_of_the_shape(small_tongue, elements, bent):
    elements.set_positions(bent)
    np.testing.assert_allclose(elements.volumes, signed_volumes(bent, small_tongue.mesh.tets), rtol=1e-12)


def test_divergence_is_the_derivative_of_the_volumes(small_tongue, elements, bent):
    free = small_tongue.free_nodes
    dx = np.zeros_like(bent)
    dx[free] = np.random.default_rng(0).standard_normal((len(free), 3))
    elements.set_positions(bent)
    h, tets = 1e-7, small_tongue.mesh.tets
    difference = (signed_volumes(bent + h * dx, tets) - signed_volumes(bent - h * dx, tets)) / (2 * h)
    np.testing.assert_allclose(elements.divergence @ dx[free].ravel(), difference, rtol=1e-6, atol=1e-12)


@pytest.mark.parametrize("precision_name", ["float64", "float32"])
def test_polynomial_equals_the_sum_over_elements(small_tongue, elements, basis, precision_name):
    tolerance = {"float64": 1e-13, "float32": 2e-6}[precision_name]
    mesh, free = small_tongue.mesh, small_tongue.free_nodes
    Q = 0.004 * np.random.default_rng(1).standard_normal((12, 3, 2))
    total = TotalVolume(volume_coefficients(mesh, basis), 2, precision_name)
    coordinates = wp.array(Q, dtype=wp.float64 if precision_name == "float64" else wp.float32, device="cpu")
    for stage in [*total.bind_gradient(coordinates), total.bind_position_step(coordinates)[0]]:
        stage()
    for t in range(2):
        elements.set_positions(mesh.nodes + basis @ Q[:, :, t])
        change = elements.volumes.sum() - mesh.volume
        slope = basis[free].T @ (elements.divergence.T @ np.ones(mesh.tet_count)).reshape(-1, 3)
        assert abs(change) > 0.01 * mesh.volume
        assert abs(total.change.numpy()[t] - change) < tolerance * mesh.volume
        assert np.abs(total.gradient.numpy()[:, :, t] - slope).max() < tolerance * np.abs(slope).max() * 10


def test_excess_jacobian_is_the_derivative_of_det_f(small_tongue, basis):
    chosen = np.arange(0, small_tongue.mesh.tet_count, 37)
    H = gradient_operator(small_tongue, basis, chosen)
    Q, dQ = 0.004 * np.random.default_rng(2).standard_normal((2, 12, 3))

    def det(coordinates):
        return np.linalg.det(np.eye(3) + (H @ coordinates).reshape(-1, 3, 3))

    difference = (det(Q + 1e-4 * dQ) - det(Q - 1e-4 * dQ)) / 2e-4
    np.testing.assert_allclose(excess_jacobian(H, Q) @ dQ.ravel(), difference, rtol=1e-5, atol=1e-9)


def test_correction_restores_the_volume_and_keeps_the_sensors(small_tongue, elements, bent):
    correction = VolumeCorrection(small_tongue, ALL)
    corrected = correction.correct_positions(bent, 3)
    sensors = small_tongue.sensors
    elements.set_positions(bent)
    before = elements.excess
    elements.set_positions(corrected)
    assert abs(before @ small_tongue.mesh.volumes) > 0.02 * small_tongue.mesh.volume
    assert abs(correction.report.drift) < 5e-6
    assert np.std(elements.excess) < 0.6 * np.std(before)
    assert np.abs(sensors.positions(corrected) - sensors.positions(bent)).max() < 1e-14
    np.testing.assert_array_equal(corrected[small_tongue.fixed_nodes], bent[small_tongue.fixed_nodes])


def test_small_corrections_solve_the_saddle_point_system(small_tongue, elements, bent, monkeypatch):
    """Against the dense equations in dx, pressures and multipliers, linearised at the present shape."""
    monkeypatch.setattr("lingual.model.volume_correction.TOLERANCE", 1e-9)
    rest, free, length = small_tongue.mesh.nodes, small_tongue.free_nodes, 0.01
    nodes = rest + 1e-5 * (bent - rest)
    elements.set_positions(nodes)
    D = elements.divergence.toarray()
    M = np.repeat(small_tongue.node_masses[free], 3)
    J = np.kron(small_tongue.sensors.weights.toarray()[:, free], np.eye(3))
    E = np.diag(small_tongue.mesh.volumes / (small_tongue.material.density * length**2))
    n, m, c = len(M), len(D), len(J)
    # A uniform pressure without compliance meets the whole volume; its displacement is that of D^T 1.
    one = D.T @ np.ones(m)
    system = np.block(
        [
            [np.diag(M), D.T, J.T, one[:, None]],
            [D, -E, np.zeros((m, c + 1))],
            [J, np.zeros((c, m + c + 1))],
            [one[None], np.zeros((1, m + c + 1))],
        ]
    )
    excess = elements.volumes - small_tongue.mesh.volumes
    right = np.concatenate([np.zeros(n), -excess, np.zeros(c), [-excess.sum()]])
    expected = np.linalg.solve(system, right)[:n].reshape(-1, 3)
    moved = VolumeCorrection(small_tongue, ALL, length).correct_positions(nodes, 1)[free] - nodes[free]
    assert np.linalg.norm(moved - expected) < 2e-3 * np.linalg.norm(expected)


def test_uniform_dilation_is_removed(small_tongue, elements):
    """The patch: with no sensor imposed, a block stretched by 1 % gets its volume back in every element."""
    X = small_tongue.mesh.nodes
    inflated = X * np.array([1.01, 1.0, 1.0])
    correction = VolumeCorrection(small_tongue, ~ALL, 0.05)
    elements.set_positions(correction.correct_positions(inflated, 5))
    assert abs(correction.report.drift) < 1e-6
    assert np.abs(elements.excess).max() < 0.002


def test_rest_is_left_alone(small_tongue):
    rest = small_tongue.mesh.nodes
    assert np.abs(VolumeCorrection(small_tongue, ALL).correct_positions(rest) - rest).max() < 1e-16


def test_corrected_velocities_are_divergence_free(small_tongue, elements, bent):
    rng = np.random.default_rng(3)
    free, volumes = small_tongue.free_nodes, small_tongue.mesh.volumes
    stretch = rng.standard_normal((3, 3))
    velocity = small_tongue.mesh.nodes * np.array([1.0, 0.0, 0.0]) @ stretch
    correction = VolumeCorrection(small_tongue, ALL)
    corrected = correction.correct_velocities(bent, velocity)
    elements.set_positions(bent)
    before, after = (elements.divergence @ v[free].ravel() for v in (velocity, corrected))
    assert abs(after.sum()) < 1e-12 * np.abs(before).sum()
    assert np.sum(after**2 / volumes) < 0.3 * np.sum(before**2 / volumes)
    sensors = small_tongue.sensors
    assert np.abs(sensors.positions(corrected) - sensors.positions(velocity)).max() < 1e-13
