"""Similarity and Hausdorff distance against shapes whose answer is known."""

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from lingual.analysis.shape_distance import fitted_similarity, hausdorff_distance

RNG = np.random.default_rng(7)
CUBE_CORNERS = np.array([[x, y, z] for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])


@pytest.fixture(scope="module")
def sphere() -> tuple[np.ndarray, np.ndarray]:
    """Vertices (1500, 3) on the unit sphere, spread along a Fibonacci spiral, and triangles of their hull."""
    n = np.arange(1500) + 0.5
    polar, azimuth = np.arccos(1.0 - 2.0 * n / len(n)), np.pi * (1.0 + 5.0**0.5) * n
    points = np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=1)
    return points, ConvexHull(points).simplices.astype(np.int32)


@pytest.fixture(scope="module")
def cube_triangles() -> np.ndarray:
    """Of CUBE_CORNERS, (12, 3)."""
    return ConvexHull(CUBE_CORNERS).simplices.astype(np.int32)


@pytest.mark.parametrize("scale", [0.3, 1.0, 2.5])
def test_a_known_similarity_is_recovered(scale):
    points = RNG.standard_normal((40, 3)) * [3.0, 2.0, 1.0]
    rotation = Rotation.from_rotvec([0.7, -1.9, 0.4]).as_matrix()
    shift = np.array([5.0, -2.0, 0.3])
    found = fitted_similarity(points, scale * points @ rotation.T + shift)
    assert found.scale == pytest.approx(scale, rel=1e-12)
    np.testing.assert_allclose(found.rotation, rotation, atol=1e-12)
    np.testing.assert_allclose(found.translation, shift, atol=1e-11)
    np.testing.assert_allclose(found.apply(points), scale * points @ rotation.T + shift, atol=1e-11)


def test_of_noisy_points_it_is_the_least_squares_fit():
    """No rotation, scale or translation nearby fits better."""
    source = RNG.standard_normal((30, 3))
    target = 1.2 * source @ Rotation.from_rotvec([0.2, 0.1, -0.5]).as_matrix().T + RNG.normal(0.0, 0.2, (30, 3))
    found = fitted_similarity(source, target)
    best = np.sum((found.apply(source) - target) ** 2)
    for _ in range(50):
        turned = Rotation.from_rotvec(RNG.normal(0.0, 0.02, 3)).as_matrix() @ found.rotation
        scale, shift = found.scale + RNG.normal(0.0, 0.01), found.translation + RNG.normal(0.0, 0.01, 3)
        assert np.sum((scale * source @ turned.T + shift - target) ** 2) > best


def test_a_mirrored_shape_is_not_reached_by_a_reflection():
    source = RNG.standard_normal((25, 3)) * [3.0, 2.0, 1.0]
    target = source * [1.0, 1.0, -1.0]
    found = fitted_similarity(source, target)
    assert np.linalg.det(found.rotation) == pytest.approx(1.0)
    assert found.scale > 0.0
    assert np.linalg.norm(found.apply(source) - target) > 0.1 * np.linalg.norm(target)


def test_concentric_cubes_are_as_far_apart_as_their_corners(cube_triangles):
    """From the outer corners the inner cube's corners are nearest; the inner ones are nearer to the outer faces."""
    inner, outer = CUBE_CORNERS, 1.5 * CUBE_CORNERS
    assert hausdorff_distance(inner, outer, cube_triangles) == pytest.approx(0.5 * 3.0**0.5, rel=1e-5)
    assert hausdorff_distance(outer, inner, cube_triangles) == pytest.approx(0.5 * 3.0**0.5, rel=1e-5)


def test_distance_is_to_the_faces_and_not_to_the_nearest_vertex(sphere):
    """Of the unit sphere and itself turned by half a vertex spacing, far less than that spacing."""
    points, triangles = sphere
    turned = points @ Rotation.from_rotvec([0.0, 0.0, 0.05]).as_matrix().T
    spacing = (4.0 * np.pi / len(points)) ** 0.5
    assert 0.0 < hausdorff_distance(points, turned, triangles) < 0.05 * spacing


@pytest.mark.parametrize("shift", [0.02, 0.3, 3.0])
def test_a_shifted_sphere_is_as_far_as_the_shift(sphere, shift):
    points, triangles = sphere
    moved = points + shift * np.array([0.6, 0.0, 0.8])
    assert hausdorff_distance(points, moved, triangles) == pytest.approx(shift, rel=0.02)


def test_a_surface_has_no_distance_from_itself(sphere):
    points, triangles = sphere
    assert hausdorff_distance(points, points, triangles) < 1e-6


def test_vertices_that_no_triangle_uses_do_not_count(cube_triangles):
    """A tetrahedral mesh has nodes inside."""
    inside = np.vstack([CUBE_CORNERS, [[0.0, 0.0, 0.0]]])
    elsewhere = np.vstack([CUBE_CORNERS, [[9.0, 0.0, 0.0]]])
    assert hausdorff_distance(inside, elsewhere, cube_triangles) < 1e-6
