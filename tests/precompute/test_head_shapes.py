"""Signed-distance shapes: signs, distances and gradients."""

import numpy as np
import pytest

from lingual.precompute.head import shapes
from lingual.precompute.surfacing import gradient


@pytest.fixture
def points() -> np.ndarray:
    return np.random.default_rng(1).uniform(-12.0, 12.0, (400, 3))


def chain(p):
    return shapes.rounded_chain(
        p, np.array([[-6.0, 0.0, 0.0], [0.0, 3.0, 0.0], [6.0, 0.0, 2.0]]), np.array([2.0, 2.0, 2.0])
    )


def box(p):
    return shapes.rounded_extrusion(np.hypot(p[:, 0], p[:, 2]) - 6.0, np.abs(p[:, 1]) - 4.0, 1.5)


@pytest.mark.parametrize(
    "field",
    [lambda p: shapes.sphere(p, (1.0, 0.0, 0.0), 5.0), chain, box],
    ids=["sphere", "chain", "rounded cylinder"],
)
def test_exact_distances_have_unit_gradient(field, points):
    outside = points[field(points) > 0.2]
    slope = np.linalg.norm(gradient(field, outside, step=1e-5), axis=1)
    assert np.median(np.abs(slope - 1.0)) < 1e-6
    assert np.quantile(slope, 0.99) < 1.0 + 1e-4


def test_first_order_distances_are_right_near_the_surface():
    rng = np.random.default_rng(2)
    radii = (3.0, 5.0, 8.0)
    direction = rng.normal(size=(200, 3))
    on = direction / np.linalg.norm(direction / radii, axis=1, keepdims=True)

    def field(p):
        return shapes.ellipsoid(p, (0.0, 0.0, 0.0), radii)

    assert np.abs(field(on)).max() < 1e-9
    normal = gradient(field, on, step=1e-5)
    assert np.allclose(np.linalg.norm(normal, axis=1), 1.0, atol=1e-3)
    assert np.allclose(field(on + 0.05 * normal), 0.05, atol=2e-3)
    angle = np.linspace(0.0, 2.0 * np.pi, 50)
    x, y = 4.0 * np.cos(angle), 2.0 * np.sin(angle)
    assert np.abs(shapes.superellipse(x, y, 4.0, 2.0, 2.0)).max() < 1e-9


def test_smooth_union_is_the_union_away_from_the_seam_and_fills_it(points):
    a = shapes.sphere(points, (-3.0, 0.0, 0.0), 4.0)
    b = shapes.sphere(points, (3.0, 0.0, 0.0), 4.0)
    union = shapes.smooth_union(a, b, 2.0)
    apart = np.abs(a - b) > 2.0
    assert np.array_equal(union[apart], np.minimum(a, b)[apart])
    assert (union <= np.minimum(a, b)).all()
    assert (shapes.smooth_intersection(a, b, 2.0) >= np.maximum(a, b)).all()
    assert (shapes.smooth_difference(a, b, 2.0) >= np.maximum(a, -b)).all()


def test_planar_field_is_the_distance_to_its_outline():
    angle = np.linspace(0.0, 2.0 * np.pi, 400, endpoint=False)
    field = shapes.PlanarField(np.stack([10.0 * np.cos(angle), 10.0 * np.sin(angle)], axis=1), margin=5.0)
    rng = np.random.default_rng(3)
    u, v = rng.uniform(-9.0, 9.0, (2, 300))
    away = np.hypot(u, v) > 1.0  # the centre is a kink
    assert np.abs(field(u, v) - (np.hypot(u, v) - 10.0))[away].max() < 0.02
    assert field(np.array([40.0]), np.array([0.0]))[0] == pytest.approx(30.0, abs=0.1)


def test_path_coordinates_of_an_arch():
    angle = np.linspace(np.pi / 2.0, -np.pi / 2.0, 2001)
    frame = shapes.PathFrame(20.0 * np.stack([np.cos(angle), np.sin(angle)], axis=1))
    assert frame.length == pytest.approx(20.0 * np.pi, rel=1e-4)
    at = np.radians(30.0)
    along, across = frame.coordinates(np.array([[23.0 * np.cos(at), 23.0 * np.sin(at)], [17.0, 0.0]]))
    assert along == pytest.approx([20.0 * at, 0.0], abs=0.02)
    assert across == pytest.approx([3.0, -3.0], abs=1e-3)
    point, tangent = frame.at(0.0)
    assert point == pytest.approx([20.0, 0.0], abs=1e-3)
    assert tangent == pytest.approx([0.0, 1.0], abs=1e-3)
