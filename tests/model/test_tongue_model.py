"""The tongue as a whole: attachment, masses, sensors, skin."""

from dataclasses import replace

import numpy as np
import pytest
import scipy.sparse as sp

from lingual.model import LingualError, RigidPose, SensorLayout


def test_lumped_masses_sum_to_density_times_volume(small_tongue):
    assert small_tongue.node_masses.sum() == pytest.approx(1000.0 * 0.06 * 0.03 * 0.02, rel=1e-12)


def test_free_and_fixed_nodes_partition_the_mesh(small_tongue):
    both = np.concatenate([small_tongue.free_nodes, small_tongue.fixed_nodes])
    assert sorted(both) == list(range(small_tongue.mesh.node_count))


def test_fixed_nodes_are_sorted_and_unique(small_tongue):
    assert replace(small_tongue, fixed_nodes=[7, 3, 3, 5]).fixed_nodes.tolist() == [3, 5, 7]


@pytest.mark.parametrize(
    ("fixed", "sentence"),
    [([], "0 fixed nodes; at least 3"), ([1, 2, 2], "2 fixed nodes"), ([0, 1, 180], "fixes node 180"),
     ([-1, 0, 1], "fixes node -1")],
)  # fmt: skip
def test_a_bad_attachment_is_named(small_tongue, fixed, sentence):
    with pytest.raises(LingualError, match=sentence):
        replace(small_tongue, fixed_nodes=np.array(fixed, dtype=int))


def test_a_sensor_is_the_weighted_mean_of_its_footprint():
    layout = SensorLayout(("TT",), sp.csr_array([[0.0, 0.25, 0.75]]))
    nodes = np.array([[9.0, 9, 9], [0, 0, 0], [4, 8, 0]])
    np.testing.assert_allclose(layout.positions(nodes), [[3, 6, 0]])
    assert layout.footprint(0).tolist() == [1, 2]


@pytest.mark.parametrize(("names", "row"), [(("TT",), [0.5, 0.4]), (("TT", "TB"), [0.5, 0.5])])
def test_sensor_weights_must_sum_to_one_and_have_names(names, row):
    with pytest.raises(LingualError):
        SensorLayout(names, sp.csr_array([row]))


def test_skin_vertices_follow_the_nodes_and_normals_point_outward(small_tongue):
    skin, mesh = small_tongue.skin, small_tongue.mesh
    stretched = mesh.nodes * [2.0, 1.0, 1.0]
    vertices = skin.vertices(stretched)
    np.testing.assert_allclose(vertices, stretched[mesh.boundary_nodes])
    normals = skin.normals(vertices)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0, rtol=1e-5)
    assert (np.einsum("vi,vi->v", normals, vertices - vertices.mean(axis=0)) > 0).all()


def test_a_pose_turns_then_moves():
    turn = np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]])
    pose = RigidPose(turn, np.array([0.0, 0, 5]))
    np.testing.assert_allclose(pose.apply(np.array([[1.0, 2, 3]])), [[-2, 1, 8]])
    np.testing.assert_allclose(pose.matrix() @ [1, 2, 3, 1], [-2, 1, 8, 1])
