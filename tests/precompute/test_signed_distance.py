"""Grids of the distance to boxes and balls against their closed forms, and their place in the cache."""

from dataclasses import replace

import numpy as np
import pytest

from lingual.model import RigidSurface, TetMesh
from lingual.model.signed_distance import SignedDistanceGrid
from lingual.precompute import signed_distance
from lingual.precompute.head import load_head
from lingual.precompute.head.anatomy import HeadAnatomy
from lingual.precompute.head.jaw import Jaw
from lingual.precompute.head.palate import UpperJaw
from lingual.precompute.signed_distance import REACH, distance_values, signed_distance_grids

RNG = np.random.default_rng(5)
SPACING = 1e-3
JAW, UPPER = Jaw(HeadAnatomy()), UpperJaw(HeadAnatomy())


def box_surface(block, centre, size) -> tuple[np.ndarray, np.ndarray]:
    """Vertices and outward triangles of a box."""
    mesh: TetMesh = block(tuple(size), (2, 2, 2))
    return mesh.nodes + np.asarray(centre) - 0.5 * np.asarray(size), mesh.boundary_triangles


def box_distance(points, centre, size) -> np.ndarray:
    q = np.abs(points - np.asarray(centre)) - 0.5 * np.asarray(size)
    return np.linalg.norm(np.maximum(q, 0.0), axis=1) + np.minimum(q.max(axis=1), 0.0)


BOXES = [((0.0, 0.0, 0.0), (0.012, 0.016, 0.010)), ((0.010, 0.0, 0.0), (0.014, 0.006, 0.030))]


@pytest.fixture(scope="module")
def two_boxes(block) -> SignedDistanceGrid:
    lower = np.full(3, -0.02)
    bodies = [box_surface(block, *box) for box in BOXES]
    return SignedDistanceGrid("jaw", lower, SPACING, distance_values(bodies, lower, -lower, SPACING))


def test_distance_is_that_of_the_union(two_boxes):
    """Away from edges, which the spline rounds off, to a hundredth of the spacing; there to a third of it."""
    points = RNG.uniform(-0.018, 0.018, (4000, 3))
    each = np.array([box_distance(points, *box) for box in BOXES])
    error = np.abs(two_boxes.sample(points)[0] - each.min(axis=0))[np.abs(each.min(axis=0)) < 3e-3]
    assert np.median(error) < 0.01 * SPACING
    assert np.percentile(error, 99) < 0.35 * SPACING


def test_sign_is_right_everywhere(two_boxes):
    """Also far from the surfaces, where distances are interpolated from coarser grids."""
    points = RNG.uniform(-0.018, 0.018, (4000, 3))
    exact = np.min([box_distance(points, *box) for box in BOXES], axis=0)
    clear = np.abs(exact) > 0.4 * SPACING
    assert np.array_equal(two_boxes.sample(points)[0][clear] > 0.0, exact[clear] > 0.0)


def test_gradient_is_the_outward_normal(two_boxes):
    points = np.array([[-0.0065, 0.001, 0.001], [0.010, 0.0, 0.0155], [0.0, -0.0075, 0.001]])
    _, gradient = two_boxes.sample(points)
    assert gradient == pytest.approx(np.array([[-1.0, 0, 0], [0, 0, 1], [0, -1, 0]]), abs=0.02)


def test_a_ball_is_a_ball(block):
    vertices, triangles = box_surface(block, (0, 0, 0), (2, 2, 2))
    for _ in range(4):  # four triangles for one, then on the sphere
        corners = vertices[triangles]
        middles = 0.5 * (corners + np.roll(corners, -1, axis=1))
        at_corners = [[corners[:, i], middles[:, i], middles[:, i - 1]] for i in range(3)]
        cut = [*at_corners, [middles[:, i] for i in range(3)]]
        vertices = np.concatenate([np.stack(c, axis=1) for c in cut]).reshape(-1, 3)
        triangles = np.arange(len(vertices)).reshape(-1, 3)
    vertices = 0.008 * vertices / np.linalg.norm(vertices, axis=1, keepdims=True)
    lower = np.full(3, -0.012)
    grid = SignedDistanceGrid(
        "jaw", lower, SPACING, distance_values([(vertices, triangles.astype(np.int32))], lower, -lower, SPACING)
    )
    direction = RNG.standard_normal((300, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    radius = RNG.uniform(0.006, 0.0095, 300)
    distance, gradient = grid.sample(radius[:, None] * direction)
    assert distance == pytest.approx(radius - 0.008, abs=3e-5)
    assert np.einsum("ni,ni->n", gradient, direction).min() > 0.99


@pytest.mark.parametrize(
    ("frame", "fields"),
    [("jaw", (JAW.bone, JAW.gums, JAW.teeth, JAW.hyoid)), ("head", (UPPER.palate, UPPER.teeth))],
)
def test_our_head_has_its_bones_inside(frame, fields, cache_folder):
    """Against the formulas that the surfaces were drawn from; a coarse grid is enough to tell the sides."""
    head = load_head()
    parts = tuple(part for part in head.rigid if part.frame == frame)
    (grid,) = signed_distance_grids(replace(head, rigid=parts), spacing=2e-3)
    surface = np.concatenate([part.vertices for part in parts])[::11]
    points = surface + RNG.normal(scale=4e-3, size=surface.shape)
    reach = grid.lower + 2e-3 * (np.array(grid.values.shape) - 2.0)
    points = points[((points > grid.lower + 2e-3) & (points < reach)).all(axis=1)]
    expected = 1e-3 * np.min([field(1e3 * points) for field in fields], axis=0)
    clear = np.abs(expected) > 1.2e-3
    assert clear.sum() > 200
    assert np.mean((grid.sample(points)[0] > 0.0)[clear] == (expected > 0.0)[clear]) > 0.99
    free = np.setdiff1d(head.mesh.boundary_nodes, head.fixed_nodes)
    assert grid.sample(head.mesh.nodes[free])[0].min() > -0.3e-3


@pytest.fixture
def tongue_in_a_mouth(small_tongue, block, cache_folder):
    """The small block with a floor that moves with the jaw and a sheet of a palate in the head."""
    floor, floor_triangles = box_surface(block, (0.03, 0.015, -0.006), (0.05, 0.025, 0.008))
    sheet = np.array([[0.0, 0, 0.024], [0.06, 0, 0.024], [0.06, 0.03, 0.024], [0.0, 0.03, 0.024]])
    palate = np.array([[0, 1, 2], [0, 2, 3]], dtype=np.int32)
    rigid = (
        RigidSurface("floor", "bone", "jaw", floor, floor_triangles),
        RigidSurface("palate", "mucosa", "head", sheet, palate),
    )
    return replace(small_tongue, rigid=rigid)


def test_a_tongue_gets_one_grid_a_frame(tongue_in_a_mouth):
    jaw, head = signed_distance_grids(tongue_in_a_mouth)
    assert (jaw.frame, head.frame) == ("jaw", "head")
    assert jaw.values.dtype == np.float32
    at = np.array([[0.03, 0.015, -0.001], [0.03, 0.015, -0.003]])
    assert jaw.sample(at)[0] == pytest.approx([1e-3, -1e-3], abs=2e-5)
    at = np.array([[0.03, 0.015, 0.023], [0.03, 0.015, 0.026]])  # below the sheet, where the tongue is, and in it
    assert head.sample(at)[0] == pytest.approx([1e-3, -2e-3], abs=2e-5)


def test_grids_come_from_the_cache_unless_something_changed(tongue_in_a_mouth, monkeypatch):
    stages: list[str] = []
    first = signed_distance_grids(tongue_in_a_mouth, progress=lambda stage, done: stages.append(stage))
    assert stages
    stages.clear()
    again = signed_distance_grids(tongue_in_a_mouth, progress=lambda stage, done: stages.append(stage))
    assert not stages
    assert all(np.array_equal(a.values, b.values) for a, b in zip(first, again, strict=True))
    lowered = replace(tongue_in_a_mouth.rigid[0], vertices=tongue_in_a_mouth.rigid[0].vertices - [0, 0, 1e-3])
    changed = signed_distance_grids(replace(tongue_in_a_mouth, rigid=(lowered, tongue_in_a_mouth.rigid[1])))
    assert changed[0].sample(np.array([[0.03, 0.015, -0.001]]))[0] == pytest.approx([2e-3], abs=2e-5)
    monkeypatch.setattr(signed_distance, "SHEET_THICKNESS", 3e-3)
    signed_distance_grids(tongue_in_a_mouth, progress=lambda stage, done: stages.append(stage))
    assert stages


def test_parts_out_of_reach_or_absent_make_no_grid(tongue_in_a_mouth, small_tongue):
    assert signed_distance_grids(small_tongue) == ()
    away = [replace(p, vertices=p.vertices + np.array([0, 0, 0.1 + 2 * REACH])) for p in tongue_in_a_mouth.rigid]
    assert signed_distance_grids(replace(small_tongue, rigid=tuple(away))) == ()
