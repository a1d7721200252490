"""Collision points stand for all surface nodes that touch: covering, areas, and what they miss."""

from dataclasses import replace

import numpy as np
import pytest

from lingual.model import RigidPose, Trajectory
from lingual.model.contact_depth import SurfacePenetration
from lingual.model.signed_distance import SignedDistanceGrid
from lingual.precompute.collision_points import (
    nodes_of,
    posed_recordings,
    select_collision_points,
)
from lingual.precompute.poses import coarse_equilibrium
from lingual.precompute.reduction import all_element_model

RNG = np.random.default_rng(9)
CEILING = 0.021


@pytest.fixture(scope="module")
def ceiling() -> tuple[SignedDistanceGrid, ...]:
    """Bone 1 mm above the small block, in the head."""
    lower, spacing = np.array([-0.01, -0.01, -0.005]), 1e-3
    height = lower[2] + spacing * np.arange(41)
    return (SignedDistanceGrid("head", lower, spacing, np.tile((CEILING - height).astype(np.float32), (81, 51, 1))),)


@pytest.fixture(scope="module")
def poses(small_tongue):
    """Bulges of the upper surface, each 5 mm wide and up to 3 mm high; the last two with a closing jaw."""
    nodes, made = small_tongue.mesh.nodes, []
    for _ in range(30):
        x, y = RNG.uniform([0.02, 0.0], [0.06, 0.03])
        bulge = np.exp(-((nodes[:, 0] - x) ** 2 + (nodes[:, 1] - y) ** 2) / 2 / 5e-3**2) * (nodes[:, 2] / 0.02)
        made.append((nodes + np.outer(bulge, [0, 0, RNG.uniform(1e-3, 3e-3)]), RigidPose()))
    made += [(nodes, RigidPose(translation=np.array([0, 0, z]))) for z in (5e-4, 1.2e-3)]
    return made


def deep(tongue, grids, poses) -> np.ndarray:
    surface = SurfacePenetration(tongue, grids)
    return np.array([surface.depths(*pose) for pose in poses])


def test_every_touched_node_has_a_point_nearby(small_tongue, ceiling, poses):
    cover = 9e-3
    points = select_collision_points(small_tongue, ceiling, poses, count=200, cover=cover)
    depths = deep(small_tongue, ceiling, poses)
    touched = np.flatnonzero(depths.max(axis=0) > 0)
    nodes = small_tongue.mesh.nodes
    distance = np.linalg.norm(nodes[touched, None] - nodes[points.nodes][None], axis=2).min(axis=1)
    assert distance.max() <= cover
    assert len(points.nodes) < len(touched)
    assert np.isin(points.nodes, touched).all()
    assert np.argmax(depths.max(axis=0)) in points.nodes
    assert points.seen_share == 1.0
    assert points.missed_depth == 0.0


def test_areas_are_those_of_the_touched_surface(small_tongue, ceiling, poses):
    points = select_collision_points(small_tongue, ceiling, poses)
    touched = deep(small_tongue, ceiling, poses).max(axis=0) > 0
    assert points.areas.sum() == pytest.approx(small_tongue.mesh.boundary_areas[touched].sum())
    assert points.areas.min() > 0.0


def test_few_points_report_what_they_miss(small_tongue, ceiling, poses):
    points = select_collision_points(small_tongue, ceiling, poses, count=3, cover=3e-3)
    assert len(points.nodes) == 3
    depths = deep(small_tongue, ceiling, poses)
    nodes = small_tongue.mesh.nodes
    near = np.linalg.norm(nodes[:, None] - nodes[points.nodes][None], axis=2) <= 3e-3
    seen = np.array([(near & (depth[points.nodes] > 0)).any(axis=1) for depth in depths])
    assert points.seen_share == pytest.approx(np.sum((depths > 0) & seen) / np.sum(depths > 0))
    assert points.missed_depth == pytest.approx(1e-3 * np.where(seen, 0.0, depths).max())
    assert 0.0 < points.seen_share < 1.0


def test_a_tongue_that_touches_nothing_has_no_points(small_tongue, ceiling):
    points = select_collision_points(small_tongue, ceiling, [(small_tongue.mesh.nodes, RigidPose())])
    assert len(points.nodes) == len(points.areas) == 0
    assert (points.seen_share, points.missed_depth) == (1.0, 0.0)


def test_recorded_poses_bring_their_jaw(small_tongue):
    model = all_element_model(small_tongue, 5)
    rest = small_tongue.sensor_rest_positions
    positions = rest + np.outer([0.0, 1e-3, 2e-3], [0, 0, 1])[:, None]
    positions[:, :, 1] = np.nan  # recorded in the midsagittal plane
    jaw = np.array([[0.0, 0, 0], [0, 0, -1e-3], [0, 0, -2e-3]])
    measured = np.tile([True, False, True], (4, 1))
    recording = Trajectory(np.arange(3) / 100, small_tongue.sensors.names, positions, measured, "jaw", jaw)
    found = list(posed_recordings(model, [recording], 2, np.random.default_rng(0)))
    assert [pose.translation.tolist() for _, pose in found] == [[0, 0, 0], [0, 0, -2e-3]]
    for (nodes, _), lift in zip(found, (0.0, 2e-3), strict=True):
        assert small_tongue.sensors.positions(nodes)[:, 2] == pytest.approx(rest[:, 2] + lift, abs=1e-6)


def test_a_frame_without_equilibrium_is_left_out(small_tongue):
    model = all_element_model(small_tongue, 5)
    rest = small_tongue.sensor_rest_positions
    crushed = rest - (rest - rest[0]) * 3.0
    assert coarse_equilibrium(model, np.random.default_rng(0))(crushed - rest) is None
    measured = np.ones((4, 3), dtype=bool)
    recording = Trajectory(np.arange(2) / 100, small_tongue.sensors.names, np.stack([rest, crushed]), measured, "jaw")
    found = list(posed_recordings(model, [recording], 5, np.random.default_rng(0)))
    assert len(found) == 1
    assert found[0][0] == pytest.approx(nodes_of(model, np.zeros((model.column_count, 3))), abs=1e-9)


def test_shared_nodes_of_a_coarser_cover_are_fewer(small_tongue, ceiling, poses):
    fine, coarse = (select_collision_points(small_tongue, ceiling, poses, cover=c) for c in (4e-3, 12e-3))
    assert len(coarse.nodes) < len(fine.nodes)
    assert coarse.areas.sum() == pytest.approx(fine.areas.sum())
    fixed = replace(small_tongue, fixed_nodes=small_tongue.mesh.boundary_nodes)
    assert len(select_collision_points(fixed, ceiling, poses).nodes) == 0
