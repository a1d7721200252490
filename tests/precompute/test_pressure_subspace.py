"""Key frames, their pressures, and the fit of the constraints on the cubature elements."""

from dataclasses import replace

import numpy as np
import pytest

from lingual.model import Trajectory
from lingual.model.volume import ElementVolumes
from lingual.model.volume_pressure import excess_jacobian
from lingual.precompute.key_frames import key_displacements, orthonormal_basis
from lingual.precompute.pressure_subspace import PressureSettings, build_pressure_subspace
from lingual.precompute.reduction import all_element_model

SETTINGS = PressureSettings(key_frame_count=24)


@pytest.fixture(scope="module")
def model(small_tongue):
    """Half of the elements at random, each with double weight: a cubature that has to be fitted."""
    exact = all_element_model(small_tongue, 5)
    chosen = np.sort(np.random.default_rng(0).permutation(small_tongue.mesh.tet_count)[::2])
    return replace(exact, cubature_elements=chosen, cubature_weights=2.0 * exact.cubature_weights[chosen])


@pytest.fixture(scope="module")
def subspace(model, tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LINGUAL_CACHE", str(tmp_path_factory.mktemp("cache")))
        yield build_pressure_subspace(model, SETTINGS)


def swing(tongue, periods: float, frames: int = 200) -> Trajectory:
    """All sensors swing up and down: the acceleration vanishes where they pass the middle."""
    t = np.arange(frames) / 100.0
    positions = np.tile(tongue.sensor_rest_positions, (frames, 1, 1))
    positions[:, :, 2] += 0.003 * np.sin(2 * np.pi * periods * t / t[-1])[:, None]
    return Trajectory(
        t, tongue.sensors.names, positions, np.ones((tongue.sensors.count, 3), dtype=bool), "jaw"
    )


def test_key_frames_are_those_of_small_acceleration(small_tongue):
    rest = small_tongue.sensor_rest_positions
    chosen = key_displacements([swing(small_tongue, 2.0)], rest, 4)
    assert chosen.shape == (4, *rest.shape)
    assert np.abs(chosen[:, :, 2]).max() < 0.0003  # a tenth of the swing


def test_key_frames_come_from_every_recording(small_tongue):
    rest = small_tongue.sensor_rest_positions
    resting = replace(swing(small_tongue, 2.0), positions=np.tile(rest + np.array([0.001, 0, 0]), (200, 1, 1)))
    chosen = key_displacements([swing(small_tongue, 1.0), resting], rest, 10)
    assert sum(np.allclose(c, [0.001, 0.0, 0.0]) for c in chosen) in (5, 6)  # one stretch may span both


def test_no_more_key_frames_than_frames(small_tongue):
    rest = small_tongue.sensor_rest_positions
    assert len(key_displacements([swing(small_tongue, 1.0, 5)], rest, 100)) == 3
    assert len(key_displacements([], rest, 100)) == 0


def test_gram_schmidt_is_orthonormal_and_spans_the_vectors():
    rng = np.random.default_rng(0)
    weights = rng.uniform(0.1, 2.0, 50)
    vectors = rng.standard_normal((6, 50)) * 10.0 ** -np.arange(6)[:, None]
    vectors = np.vstack([vectors, vectors[0] + 2.0 * vectors[1]])  # one that adds nothing
    P = orthonormal_basis(vectors, weights, 100, 1e-9)
    assert P.shape == (50, 7)
    np.testing.assert_allclose(P.T @ (weights[:, None] * P), np.eye(7), atol=1e-12)
    np.testing.assert_allclose(P[:, 0], P[0, 0])
    np.testing.assert_allclose(P @ (P.T @ (weights[:, None] * vectors.T)), vectors.T, atol=1e-9)


def test_gram_schmidt_stops_at_the_count_and_at_the_remainder():
    vectors = np.random.default_rng(1).standard_normal((6, 50)) * 10.0 ** -np.arange(6)[:, None]
    assert orthonormal_basis(vectors, np.ones(50), 3, 0.0).shape == (50, 3)
    assert orthonormal_basis(vectors, np.ones(50), 100, 0.05).shape[1] in (3, 4)
    assert orthonormal_basis(np.zeros((2, 50)), np.ones(50), 100, 0.0).shape == (50, 1)


def test_basis_is_orthonormal_in_the_volumes(model, subspace):
    V = model.tongue.mesh.volumes
    P = subspace.basis
    assert 1 < subspace.mode_count <= SETTINGS.mode_count
    np.testing.assert_allclose(P.T @ (V[:, None] * P), np.eye(P.shape[1]), atol=1e-10)


def test_fitted_constraints_follow_the_exact_ones(model, subspace):
    """On a pose that no key frame gave: values and Jacobian against finite differences over all elements."""
    rng = np.random.default_rng(2)
    mesh, V = model.tongue.mesh, model.tongue.mesh.volumes
    X = mesh.nodes
    s = X[:, :1] / X[:, 0].max()
    smooth = np.stack([0.005 * s**2 * rng.standard_normal(3) + 0.1 * s * X @ rng.standard_normal((3, 3)) for _ in "pd"])
    pose, direction = np.einsum("nk,n,pni->pki", model.basis, model.tongue.node_masses, smooth)
    elements = ElementVolumes(mesh, model.tongue.free_nodes)

    def exact(coordinates):
        elements.set_positions(mesh.nodes + model.basis @ coordinates)
        return subspace.basis.T @ (V * elements.excess)

    H = model.gradient_operator
    excess = np.linalg.det(np.eye(3) + (H @ pose).reshape(-1, 3, 3)) - 1.0
    difference = (exact(pose + 1e-4 * direction) - exact(pose - 1e-4 * direction)) / 2e-4
    fitted = subspace.cubature_rows @ excess_jacobian(H, pose) @ direction.ravel()
    assert subspace.cubature_error < 0.1
    assert np.linalg.norm(subspace.cubature_rows @ excess - exact(pose)) < 0.1 * np.linalg.norm(exact(pose))
    assert np.linalg.norm(fitted - difference) < 0.1 * np.linalg.norm(difference)


def test_the_cache_gives_the_same_subspace(model, cache_folder):
    first = build_pressure_subspace(model, SETTINGS)
    stages: list[str] = []
    second = build_pressure_subspace(model, SETTINGS, progress=lambda stage, _: stages.append(stage))
    assert not stages
    np.testing.assert_array_equal(first.cubature_rows, second.cubature_rows)
    assert (first.cubature_error, first.key_frame_count) == (second.cubature_error, second.key_frame_count)
