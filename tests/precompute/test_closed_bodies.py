"""Rigid parts become closed bodies with the tongue outside, whatever their triangles' sense."""

import numpy as np
import pytest

from lingual.model import LingualError, RigidSurface
from lingual.precompute.closed_bodies import closed_body
from lingual.precompute.tetrahedralise import edge_use, enclosed_volume

ABOVE = np.array([[0.005, 0.005, 0.004], [0.002, 0.008, 0.006]])
THICKNESS = 2e-3


def part(vertices, triangles) -> RigidSurface:
    return RigidSurface("part", "bone", "jaw", np.asarray(vertices, float), np.asarray(triangles, np.int32))


def sheet(count: int = 5, bulge: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """A square of 10 mm at z = 0 and more in its middle, normals up."""
    x, y = (a.ravel() for a in np.meshgrid(*2 * [np.linspace(0, 0.01, count)], indexing="ij"))
    z = bulge * np.sin(np.pi * x / 0.01) * np.sin(np.pi * y / 0.01)
    i = np.arange(count * count).reshape(count, count)
    a, b, c, d = i[:-1, :-1].ravel(), i[1:, :-1].ravel(), i[1:, 1:].ravel(), i[:-1, 1:].ravel()
    return np.stack([x, y, z], axis=1), np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])


def sphere(count: int = 16) -> tuple[np.ndarray, np.ndarray]:
    """A cube's six faces, blown up to a unit sphere, normals outward."""
    square, triangles = sheet(count)
    square = 200.0 * square[:, :2] - 1.0
    faces = []
    for axis in range(3):
        for side in (-1.0, 1.0):
            u, v = square[:, 0], square[:, 1] * side
            face = np.roll(np.stack([u, v, np.full(len(u), side)], axis=1), axis, axis=1)
            faces.append(face / np.linalg.norm(face, axis=1, keepdims=True))
    offsets = np.arange(6)[:, None, None] * len(square)
    return np.concatenate(faces), (triangles[None] + offsets).reshape(-1, 3)


def is_closed(triangles: np.ndarray) -> bool:
    return len(edge_use(triangles)[1]) == 0


@pytest.mark.parametrize("inside_out", [False, True])
def test_a_closed_body_stays_and_faces_outward(inside_out):
    vertices, triangles = sphere()
    points, faces = closed_body(part(vertices, triangles[:, ::-1] if inside_out else triangles), ABOVE)
    assert is_closed(faces)
    assert enclosed_volume(points, faces) == pytest.approx(4 / 3 * np.pi, rel=0.02)


def test_a_body_with_a_small_hole_is_not_made_a_plate():
    vertices, triangles = sphere()
    points, faces = closed_body(part(vertices, triangles[1:]), ABOVE)
    assert len(faces) == len(triangles) - 1
    assert enclosed_volume(points, faces) == pytest.approx(4 / 3 * np.pi, rel=0.02)


@pytest.mark.parametrize("sense", ["up", "down", "mixed"])
def test_a_sheet_becomes_a_plate_behind_itself(sense):
    vertices, triangles = sheet()
    if sense == "down":
        triangles = triangles[:, ::-1]
    if sense == "mixed":
        triangles[::3] = triangles[::3, ::-1]
    points, faces = closed_body(part(vertices, triangles), ABOVE, THICKNESS)
    assert is_closed(faces)
    assert enclosed_volume(points, faces) == pytest.approx(1e-4 * THICKNESS, rel=1e-6)
    assert points[:, 2].min() == pytest.approx(-THICKNESS)
    assert points[:, 2].max() == pytest.approx(0.0)


def test_the_side_is_that_of_the_tongue():
    points, faces = closed_body(part(*sheet()), -ABOVE * [-1, -1, 1], THICKNESS)
    assert points[:, 2].max() == pytest.approx(THICKNESS)
    assert enclosed_volume(points, faces) > 0.0


def test_each_piece_of_a_part_is_treated_by_itself():
    """A palate above and a bulging floor below, in one part, with the tongue between them."""
    floor, triangles = sheet(bulge=1e-3)
    vertices = np.concatenate([floor, floor + np.array([0, 0, 0.02])])
    points, faces = closed_body(part(vertices, np.concatenate([triangles, triangles + len(floor)])), ABOVE, THICKNESS)
    assert is_closed(faces)
    low = points[:, 2] < 0.01
    assert points[low, 2].min() == pytest.approx(-THICKNESS, rel=0.1)
    assert points[~low, 2].max() == pytest.approx(0.021 + THICKNESS, rel=0.01)


@pytest.mark.parametrize(
    ("vertices", "triangles", "message"),
    [
        ([[0.0, 0, 0], [1, 0, 0], [0, 1, np.nan]], [[0, 1, 2]], "not finite"),
        ([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]], np.zeros((0, 3)), "no triangle"),
    ],
)
def test_an_unusable_part_is_named(vertices, triangles, message):
    with pytest.raises(LingualError, match=f"'part'.*{message}"):
        closed_body(part(vertices, triangles), ABOVE)
