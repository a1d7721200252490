"""Cubature: exact with every element, positive weights, an error that falls as elements are added."""

from dataclasses import replace

import numpy as np
import pytest

from lingual.model.discretisation import Discretisation
from lingual.model.reduced_forces import ReducedForces
from lingual.precompute.cubature import _training_system, relative_force_errors, select_cubature
from lingual.precompute.poses import equilibrium_poses, sampled_displacements
from lingual.precompute.progress import silent
from lingual.precompute.reduction import all_element_model


@pytest.fixture(scope="module")
def model(small_tongue):
    return all_element_model(small_tongue, 5)


@pytest.fixture(scope="module")
def poses(small_tongue, model):
    """30 poses, none of them held out yet."""
    rng = np.random.default_rng(14)
    return equilibrium_poses(model, sampled_displacements(small_tongue.sensor_rest_positions, 30, rng), rng)


@pytest.fixture(scope="module")
def select(model, poses):
    """Function (element_count, tolerance) -> the model with a cubature trained on the first 20 poses."""

    def run(element_count: int, tolerance: float = 0.0):
        rng = np.random.default_rng(15)
        elements, weights = select_cubature(model, poses[:20], element_count, tolerance, rng)
        return replace(model, cubature_elements=elements, cubature_weights=weights)

    return run


def root_mean_square(errors):
    return float(np.sqrt(np.mean(errors**2)))


@pytest.mark.parametrize("step", [None, 0.01], ids=["elastic", "damped"])
def test_all_elements_give_the_full_force_and_stiffness_projected_on_the_basis(small_tongue, model, poses, step):
    """To 1e-10, in double precision, at a large deformation."""
    full = Discretisation(small_tongue.mesh, small_tongue.material)
    reduced = ReducedForces(small_tongue.material, model.gradient_operator, model.cubature_weights)
    U = np.kron(model.basis, np.eye(3))
    for start, pose in zip(poses[:3], poses[3:6], strict=True):
        full.set_displacement(model.basis @ start)
        full.elements.begin_step()
        full.set_displacement(model.basis @ pose)
        reduced.set_coordinates(start)
        reduced.elements.begin_step()
        reduced.set_coordinates(pose)
        force = model.basis.T @ full.internal_force(step)
        K = U.T @ (full.stiffness(step) @ U)
        assert np.linalg.norm(reduced.force(step) - force) < 1e-10 * np.linalg.norm(force)
        assert np.linalg.norm(reduced.stiffness(step) - K) < 1e-10 * np.linalg.norm(K)


def test_elements_are_distinct_and_weights_positive_and_about_the_volume_in_sum(small_tongue, select):
    chosen = select(400)
    assert 300 < len(chosen.cubature_elements) <= 400
    assert np.all(np.diff(chosen.cubature_elements) > 0)
    assert chosen.cubature_weights.min() > 0.0
    assert chosen.cubature_weights.sum() == pytest.approx(small_tongue.mesh.volume, rel=0.2)


def test_the_error_on_held_out_poses_falls_as_elements_are_added(select, poses):
    errors = [root_mean_square(relative_force_errors(select(n), poses[20:])) for n in (20, 60, 180, 400)]
    assert errors[0] > 1.3 * errors[1] > 2.0 * errors[2] > 4.0 * errors[3]
    assert errors[3] < 0.1


def test_selection_stops_when_the_tolerance_is_reached(select, poses):
    loose, tight = select(500, 0.3), select(500, 0.15)
    assert len(loose.cubature_elements) < len(tight.cubature_elements) < 400
    assert root_mean_square(relative_force_errors(tight, poses[:20])) < 0.15 * 1.001


def test_forces_projected_on_random_directions_select_as_well(select, poses, monkeypatch):
    """20 of 50 columns a pose: an error close to that of all of them, which fewer equations alone would not have."""
    exact = root_mean_square(relative_force_errors(select(180), poses[20:]))
    monkeypatch.setattr("lingual.precompute.cubature.TRAINING_ROWS", 3 * 20 * 20)
    projected = root_mean_square(relative_force_errors(select(180), poses[20:]))
    assert exact != projected
    assert projected < 1.6 * exact


def test_projection_keeps_the_size_of_forces(model, poses, monkeypatch):
    """Each pose's exact force has length one before, and about one after."""
    monkeypatch.setattr("lingual.precompute.cubature.TRAINING_ROWS", 3 * 30 * 25)
    rng = np.random.default_rng(3)
    _, target = _training_system(model, poses[:20], np.arange(40), rng, silent)
    lengths = np.linalg.norm(target.reshape(20, -1), axis=1)
    assert len(target) == 20 * 3 * 37
    assert lengths.std() > 0.0
    assert lengths.mean() == pytest.approx(1.0, abs=0.1)


def test_all_elements_have_no_error(model, poses):
    assert relative_force_errors(model, poses[:3]).max() < 1e-12
