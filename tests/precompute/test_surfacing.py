"""Surfaces of implicit shapes: closed, outward, on the zero level, with even triangles; and fewer of them."""

import numpy as np
import pytest

from lingual.model import LingualError
from lingual.precompute.decimation import decimate
from lingual.precompute.surfacing import surface_of
from lingual.precompute.tetrahedralise import enclosed_volume

RADIUS, RING = 3.0, 8.0


def torus(p):
    return np.hypot(np.hypot(p[:, 0], p[:, 1]) - RING, p[:, 2]) - RADIUS


def torus_surface(spacing=0.8):
    return surface_of(torus, (-13.0, -13.0, -5.0), (13.0, 13.0, 5.0), spacing)


def edge_use(triangles):
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    return np.unique(edges, axis=0, return_counts=True)


def test_surface_is_closed_outward_and_on_the_zero_level():
    vertices, triangles = torus_surface()
    edges, use = edge_use(triangles)
    assert (use == 2).all()
    assert len(vertices) - len(edges) + len(triangles) == 0  # Euler characteristic of a torus
    assert np.abs(torus(vertices)).max() < 1e-4
    assert enclosed_volume(vertices, triangles) == pytest.approx(2.0 * np.pi**2 * RING * RADIUS**2, rel=0.02)


def test_triangles_are_even():
    vertices, triangles = torus_surface()
    corner = vertices[triangles]
    sides = np.linalg.norm(corner - np.roll(corner, 1, axis=1), axis=2)
    assert np.quantile(sides.max(axis=1) / sides.min(axis=1), 0.99) < 2.5


def test_volume_error_falls_with_the_square_of_the_spacing():
    exact = 2.0 * np.pi**2 * RING * RADIUS**2
    errors = [abs(enclosed_volume(*torus_surface(h)) / exact - 1.0) for h in (1.2, 0.6)]
    assert errors[1] < errors[0] / 3.0


def test_box_must_hold_the_shape():
    with pytest.raises(LingualError, match="cuts through"):
        surface_of(torus, (-9.0, -13.0, -5.0), (13.0, 13.0, 5.0), 1.0)
    with pytest.raises(LingualError, match="no inside"):
        surface_of(lambda p: np.ones(len(p)), (-1.0, -1.0, -1.0), (1.0, 1.0, 1.0), 0.5)


def test_decimation_keeps_the_surface():
    vertices, triangles = torus_surface(0.6)
    fewer, faces = decimate(vertices, triangles, len(triangles) // 3)
    assert len(faces) == pytest.approx(len(triangles) / 3, rel=0.02)
    edges, use = edge_use(faces)
    assert (use == 2).all()
    assert len(fewer) - len(edges) + len(faces) == 0
    assert np.abs(torus(fewer)).max() < 0.1
    assert enclosed_volume(fewer, faces) == pytest.approx(enclosed_volume(vertices, triangles), rel=0.02)
