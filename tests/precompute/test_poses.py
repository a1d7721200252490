"""Training poses: what sensors are made to do, and the equilibria that follow."""

import numpy as np
import pytest

from lingual.model import Trajectory
from lingual.model.reduced_forces import ReducedForces
from lingual.precompute.poses import equilibrium_poses, recorded_displacements, sampled_displacements
from lingual.precompute.reduction import all_element_model


@pytest.fixture(scope="module")
def model(small_tongue):
    return all_element_model(small_tongue, 5)


@pytest.fixture(scope="module")
def displacements(small_tongue):
    return sampled_displacements(small_tongue.sensor_rest_positions, 6, np.random.default_rng(11))


@pytest.fixture(scope="module")
def poses(model, displacements):
    return equilibrium_poses(model, displacements, np.random.default_rng(12))


def test_sampled_displacements_have_speech_like_size_and_neighbours_move_together(small_tongue):
    d = 1e3 * sampled_displacements(small_tongue.sensor_rest_positions, 4000, np.random.default_rng(13))
    assert d.shape == (4000, 4, 3)
    np.testing.assert_allclose(d.std(axis=(0, 1)), [3.1, 1.2, 3.1], rtol=0.1)
    near = np.corrcoef(d[:, 2, 2], d[:, 3, 2])[0, 1]  # TD and TR, 7.5 mm apart
    far = np.corrcoef(d[:, 0, 2], d[:, 3, 2])[0, 1]  # TT and TR, 37.5 mm apart
    assert near > 0.85
    assert far < 0.4


def test_recorded_frames_are_spread_evenly_and_unmeasured_coordinates_do_not_move(small_tongue):
    rest = small_tongue.sensor_rest_positions
    positions = rest + 1e-3 * np.arange(10)[:, None, None] * np.ones((10, 4, 3))
    positions[..., 1] = np.nan
    measured = np.tile([True, False, True], (4, 1))
    recording = Trajectory(np.arange(10) / 100, small_tongue.sensors.names, positions, measured, "jaw")
    chosen = recorded_displacements([recording], rest, 4)
    np.testing.assert_allclose(chosen[:, 0, 0], [0, 0.003, 0.006, 0.009])
    assert not chosen[..., 1].any()
    assert len(recorded_displacements([recording], rest, 99)) == 10


def test_poses_meet_their_targets_and_are_in_equilibrium(small_tongue, model, displacements, poses):
    """All 576 elements are among the coarse ones, but at equal weights: the force balance is theirs."""
    assert poses.shape == (6, 50, 3)
    for pose, displacement in zip(poses, displacements, strict=True):
        np.testing.assert_allclose(model.sensor_rows @ pose, displacement, rtol=0, atol=1e-7)
        mesh = small_tongue.mesh
        weights = np.full(mesh.tet_count, mesh.volume / mesh.tet_count)
        forces = ReducedForces(small_tongue.material, model.gradient_operator, weights)
        forces.set_coordinates(pose)
        force = forces.force()
        rows = model.sensor_rows
        explained = rows.T @ np.linalg.lstsq(rows.T, force, rcond=None)[0]
        assert np.linalg.norm(force - explained) < 1e-3 * np.linalg.norm(force)


def test_a_target_without_equilibrium_is_left_out(model, displacements):
    impossible = np.zeros((1, 4, 3))
    impossible[0, 0, 0] = -0.2  # the tip 20 cm back, through the held face
    kept = equilibrium_poses(model, np.concatenate([displacements[:2], impossible]), np.random.default_rng(12))
    assert len(kept) == 2


def test_the_same_generator_gives_the_same_poses(model, displacements, poses):
    again = equilibrium_poses(model, displacements, np.random.default_rng(12))
    np.testing.assert_array_equal(again, poses)
