"""Geometry of tetrahedral meshes, and the sentence for each kind of bad one."""

import numpy as np
import pytest

from lingual.model import LingualError, TetMesh

NODES = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 1, 1]], dtype=float)
TETS = [[0, 1, 2, 3], [1, 4, 2, 3]]


@pytest.fixture(scope="module")
def mesh(block):
    return block((0.03, 0.02, 0.01), (3, 2, 2))


def test_volumes_sum_to_the_box(mesh):
    assert mesh.volume == pytest.approx(6e-6, rel=1e-12)
    assert mesh.node_volumes.sum() == pytest.approx(6e-6, rel=1e-12)
    assert (mesh.volumes > 0).all()


def test_shape_gradients_reproduce_any_linear_field(mesh):
    slope = np.array([2.0, -3.0, 0.5])
    values = (mesh.nodes @ slope + 7.0)[mesh.tets]
    gradient = np.einsum("ea,eaj->ej", values, mesh.shape_gradients)
    np.testing.assert_allclose(gradient, np.tile(slope, (mesh.tet_count, 1)), atol=1e-10)


def test_boundary_is_closed_and_faces_outward(mesh):
    triangles = mesh.boundary_triangles
    assert len(triangles) == 2 * 2 * (3 * 2 + 3 * 2 + 2 * 2)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    assert {tuple(e) for e in edges} == {tuple(e[::-1]) for e in edges}
    a, b, c = mesh.nodes[triangles].transpose(1, 0, 2)
    enclosed = np.einsum("ti,ti->", np.cross(a, b), c) / 6.0  # positive only if outward
    assert enclosed == pytest.approx(mesh.volume, rel=1e-12)


def test_boundary_nodes_are_those_on_the_faces_of_the_box(mesh):
    on_face = ((mesh.nodes == 0) | np.isclose(mesh.nodes, [0.03, 0.02, 0.01])).any(axis=1)
    assert mesh.boundary_nodes.tolist() == np.flatnonzero(on_face).tolist()


@pytest.mark.parametrize(
    ("nodes", "tets", "sentence"),
    [
        (NODES[:, :2], TETS, "node coordinates of shape"),
        (NODES[:3], TETS, "node coordinates of shape"),
        (NODES, [[0, 1, 2]], "elements of shape"),
        (NODES, np.zeros((0, 4)), "elements of shape"),
        (NODES, [[0, 1, 2, 9]], "element 0 names node 9, but the nodes are 0 to 4"),
        (NODES, [TETS[0], [0, 1, -2, 3]], "element 1 names node -2"),
        (NODES, [*TETS, [3, 0, 1, 2]], "element 2 repeats element 0"),
        (NODES, [TETS[0], [4, 1, 2, 3]], r"element 1 is inverted \(signed volume -3.33e\+08 mm\^3; 1 such"),
        (np.vstack([NODES, [0.5, 0.5, 0]]), [*TETS, [0, 1, 2, 5]], "element 2 is flat"),
        (np.where(np.eye(5, 3, -4), np.nan, NODES), TETS, "node 4 has a coordinate that is not a finite number"),
        (np.where(np.eye(5, 3, -2), np.inf, NODES), TETS, "node 2 has a coordinate that is not a finite number"),
    ],
)
def test_a_bad_mesh_is_named_in_one_sentence(nodes, tets, sentence):
    with pytest.raises(LingualError, match=sentence):
        TetMesh(nodes, np.array(tets))


def test_an_element_that_is_small_for_its_mesh_is_not_called_flat():
    TetMesh(np.vstack([1e-3 * NODES, [[1.0, 0, 0]]]), np.array(TETS))
