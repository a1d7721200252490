"""Penetration of the whole surface, against distances in closed form."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lingual.model import RigidPose
from lingual.model.contact_depth import ContactDepth, JawPoses, SurfacePenetration


@pytest.fixture(scope="module")
def tongue(block, tongue_of):
    """A block of 16 x 8 x 6 mm in the grids' middle, held at x = 0."""
    mesh = block((0.016, 0.008, 0.006), (8, 4, 3))
    return tongue_of(mesh, {"TT": 179, "TB": 120, "TD": 80, "TR": 40})


@pytest.fixture(scope="module")
def ceiling(floor):
    """Everything 1 mm above the block, in the head."""
    below = floor(0.0, "head")
    return replace(below, lower=below.lower + np.array([0, 0, 0.007]), values=-below.values)


def test_depth_and_count_are_those_of_the_nodes(tongue, ceiling):
    surface = SurfacePenetration(tongue, (ceiling,))
    assert surface.measure(tongue.mesh.nodes, RigidPose()).contact_count == 0
    raised = tongue.mesh.nodes + np.outer(tongue.mesh.nodes[:, 0], [0, 0, 0.2])
    free = np.setdiff1d(tongue.mesh.boundary_nodes, tongue.fixed_nodes)
    free = free[tongue.mesh.nodes[free, 0] < 0.0115]  # the grid ends there
    expected = np.zeros(tongue.mesh.node_count)
    expected[free] = 1e3 * np.maximum(raised[free, 2] - 0.007, 0.0)
    assert surface.depths(raised, RigidPose()) == pytest.approx(expected, abs=1e-5)
    measured = surface.measure(raised, RigidPose())
    assert measured.deepest == pytest.approx(expected.max(), abs=1e-5)
    assert measured.contact_count == (expected > 0).sum() > 3


def test_the_jaw_carries_the_tongue(tongue, ceiling):
    surface = SurfacePenetration(tongue, (ceiling,))
    closed = RigidPose(translation=np.array([0, 0, 1.5e-3]))
    assert surface.measure(tongue.mesh.nodes, closed).deepest == pytest.approx(0.5, abs=1e-4)
    tilted = RigidPose(Rotation.from_rotvec([0.3, 0, 0]).as_matrix())
    nodes = tongue.mesh.nodes
    free = np.setdiff1d(tongue.mesh.boundary_nodes, tongue.fixed_nodes)
    inside_grid = nodes[free, 0] < 0.0115
    expected = 1e3 * (tilted.apply(nodes[free])[inside_grid, 2].max() - 0.007)
    assert surface.measure(nodes, tilted).deepest == pytest.approx(expected, abs=1e-4)


def test_attached_nodes_are_left_out(tongue, ceiling):
    nodes = tongue.mesh.nodes.copy()
    nodes[tongue.fixed_nodes, 2] += 0.003
    assert SurfacePenetration(tongue, (ceiling,)).measure(nodes, RigidPose()).contact_count == 0


def test_without_rigid_parts_nothing_is_touched(tongue):
    measured = SurfacePenetration(tongue, ()).measure(tongue.mesh.nodes + 0.05, RigidPose())
    assert (measured.deepest, measured.contact_count) == (0.0, 0)


def test_a_point_in_both_frames_bodies_has_both_depths(floor, ceiling):
    depth = ContactDepth(np.array([[0.0, 0, 1e-3]]), (ceiling, floor()))
    depth.displacement.assign(np.array([[[0.0], [0], [-2e-3]]]))
    depth.poses.assign(RigidPose(translation=np.array([0, 0, 8.5e-3])))
    depth.evaluate()
    assert depth.depth.numpy()[:, 0, 0] == pytest.approx([1e-3, 0.5e-3], abs=1e-8)


def test_poses_are_set_for_all_or_for_each():
    poses = JawPoses(2)
    poses.assign([RigidPose(), RigidPose(translation=np.array([1.0, 2, 3]))])
    assert poses.translation.numpy().tolist() == [[0, 0, 0], [1, 2, 3]]
    copy = JawPoses(2)
    copy.copy_from(poses)
    assert np.array_equal(copy.translation.numpy(), poses.translation.numpy())
    assert np.array_equal(copy.rotation.numpy(), np.tile(np.eye(3), (2, 1, 1)))
