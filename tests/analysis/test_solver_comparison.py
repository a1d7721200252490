"""Surface distances of runs that are made up, so that every distance is known."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lingual.analysis.solver_comparison import SolverRun, most_different_time, node_distance, surface_distance
from lingual.model import StateHistory

TIMES = np.array([0.0, 0.01, 0.02])


@pytest.fixture
def run_of(small_tongue):
    """Function (shapes (frame_count, node_count, 3), times) -> SolverRun that went through them."""

    def make(shapes, times=TIMES) -> SolverRun:
        sensors = small_tongue.sensors
        history = StateHistory(small_tongue.mesh.node_count, sensors.count, len(shapes))
        for time, nodes in zip(times, shapes, strict=True):
            at = sensors.positions(nodes)
            history.append(time, nodes, at, at, np.zeros(3))
        return SolverRun("run", 3, history)

    return make


@pytest.fixture(scope="module")
def bent(small_tongue) -> np.ndarray:
    """Three shapes of the small tongue, bent further upwards in each, (3, node_count, 3)."""
    rest = small_tongue.mesh.nodes
    lift = np.array([2.0, 4.0, 6.0])[:, None] * rest[:, 0] ** 2
    shapes = np.tile(rest, (3, 1, 1))
    shapes[:, :, 2] += lift
    return shapes


def test_a_run_has_no_distance_from_itself(small_tongue, run_of, bent):
    run = run_of(bent)
    distance = surface_distance(small_tongue, run, run)
    for values in (distance.mean, distance.maximum, distance.hausdorff, distance.relative):
        assert values.shape == (3,)
        assert abs(values).max() < 1e-4
    assert not node_distance(run, run, TIMES[1]).any()


def test_a_translation_is_a_distance_in_millimetres_that_alignment_removes(small_tongue, run_of, bent):
    shift = np.array([0.0, 0.0, 0.001]) * np.array([1.0, 5.0, 2.0])[:, None, None]
    reference, moved = run_of(bent), run_of(bent + shift)
    distance = surface_distance(small_tongue, moved, reference)
    np.testing.assert_allclose(distance.mean, [1.0, 5.0, 2.0], rtol=1e-4)
    np.testing.assert_allclose(distance.maximum, [1.0, 5.0, 2.0], rtol=1e-4)
    assert distance.hausdorff.max() < 1e-3
    assert most_different_time(moved, reference, distance) == TIMES[1]
    np.testing.assert_allclose(node_distance(moved, reference, TIMES[2]), 2.0, rtol=1e-4)


def test_rotation_and_scale_are_removed_too(small_tongue, run_of, bent):
    turned = 1.1 * bent @ Rotation.from_rotvec([0.0, 0.3, 0.1]).as_matrix().T
    distance = surface_distance(small_tongue, run_of(turned), run_of(bent))
    assert distance.maximum.min() > 5.0
    assert distance.hausdorff.max() < 1e-3


def test_another_shape_keeps_its_hausdorff_distance_relative_to_the_size(small_tongue, run_of, bent):
    rest = np.tile(small_tongue.mesh.nodes, (3, 1, 1))
    distance = surface_distance(small_tongue, run_of(bent), run_of(rest))
    assert np.all(np.diff(distance.hausdorff) > 0.1)
    assert np.all(distance.hausdorff < distance.maximum)
    diagonal = np.linalg.norm([60.0, 30.0, 20.0])
    np.testing.assert_allclose(distance.relative, distance.hausdorff / diagonal, rtol=1e-12)


def test_nodes_inside_do_not_count(small_tongue, run_of, bent):
    inside = np.setdiff1d(np.arange(small_tongue.mesh.node_count), small_tongue.mesh.boundary_nodes)
    stirred = bent.copy()
    stirred[:, inside] += 0.01
    distance = surface_distance(small_tongue, run_of(stirred), run_of(bent))
    assert distance.maximum.max() < 1e-6
    assert distance.hausdorff.max() < 1e-3


def test_a_run_that_ended_early_is_compared_as_far_as_it_went(small_tongue, run_of, bent):
    short = run_of(bent[:2] + np.array([0.0, 0.002, 0.0]), TIMES[:2])
    distance = surface_distance(small_tongue, short, run_of(bent))
    np.testing.assert_allclose(distance.mean, [2.0, 2.0], rtol=1e-4)
