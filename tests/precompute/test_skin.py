"""The display surface: weights, closeness to the boundary, smoothness, and that it follows the mesh."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from lingual.model import TetMesh
from lingual.precompute.skin import skin_of
from lingual.precompute.surfacing import surface_of
from lingual.precompute.tetrahedralise import enclosed_volume, tetrahedralise


@pytest.fixture(scope="module")
def ball() -> TetMesh:
    vertices, triangles = surface_of(lambda p: np.linalg.norm(p, axis=1) - 20.0, (-22,) * 3, (22,) * 3, 2.5)
    return tetrahedralise(vertices * 1e-3, triangles, 900)


def test_weights_sum_to_one_and_carry_any_affine_motion(ball):
    skin = skin_of(ball)
    assert np.allclose(skin.weights.sum(axis=1), 1.0)
    motion = np.array([[1.1, 0.2, 0.0], [0.0, 0.9, 0.1], [0.3, 0.0, 1.0]])
    moved = skin.vertices(ball.nodes @ motion.T + 0.01)
    assert np.allclose(moved, skin.vertices(ball.nodes) @ motion.T + 0.01, atol=1e-12)


def test_skin_is_closed_outward_and_near_the_boundary(ball):
    skin = skin_of(ball)
    vertices = skin.vertices(ball.nodes)
    edges = np.sort(skin.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()
    assert enclosed_volume(vertices, skin.triangles) == pytest.approx(ball.volume, rel=0.03)
    assert np.abs(np.linalg.norm(vertices, axis=1) - 0.020).max() < 1e-3
    assert cKDTree(vertices).query(ball.nodes[ball.boundary_nodes])[0].max() < 1.5e-3


def test_skin_is_smoother_than_the_boundary(ball):
    skin = skin_of(ball)
    vertices = skin.vertices(ball.nodes)
    normals = skin.normals(vertices)
    radial = vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    assert np.degrees(np.arccos(np.clip((normals * radial).sum(axis=1), -1.0, 1.0))).max() < 8.0


def test_subdivided_until_there_are_enough_vertices(ball):
    once = skin_of(ball, vertex_count=100)
    twice = skin_of(ball, vertex_count=100_000)
    assert len(once.triangles) == 4 * len(ball.boundary_triangles)
    assert len(twice.triangles) == 16 * len(ball.boundary_triangles)
