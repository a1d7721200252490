"""From a tongue's mouth to what its solvers need for contact: distance grids and collision points; cached."""

from collections.abc import Iterator

import numpy as np

from ..model import ReducedModel, RigidPose, Trajectory
from ..model.contact_forces import CollisionPoints
from ..model.contact_scene import ContactScene
from ..model.signed_distance import SignedDistanceGrid
from .cache import Arrays, cached, digest
from .collision_points import POINT_COUNT, PosedNodes, nodes_of, posed_recordings, select_collision_points
from .keys import tongue_key
from .poses import coarse_equilibrium, sampled_displacements
from .progress import Progress, silent
from .signed_distance import signed_distance_grids

ALGORITHM_VERSION = 1
RECORDED_POSES = 60
SAMPLED_POSES = 60
SEED = 2017


def build_contact_scene(
    model: ReducedModel, recordings: list[Trajectory], progress: Progress = silent
) -> ContactScene | None:
    """What the tongue may touch, None without rigid parts in its reach.

    recordings: training motions, fitted to the sensors; as many sampled poses, in a closed mouth, are added.
    """
    tongue = model.tongue
    grids = signed_distance_grids(tongue, progress=progress)
    if not grids:
        return None
    key = {
        "algorithm": ALGORITHM_VERSION,
        **tongue_key(tongue),
        "basis": digest(model.basis),
        "grids": [digest(grid.lower, grid.values) for grid in grids],
        "recordings": [digest(r.positions, r.jaw_translation) for r in recordings],
        "count": POINT_COUNT,
    }
    arrays = cached("contact", key, lambda: _build(model, grids, recordings, progress))
    points = CollisionPoints(
        nodes=arrays["nodes"],
        areas=arrays["areas"],
        seen_share=float(arrays["seen_share"]),
        missed_depth=float(arrays["missed_depth"]),
    )
    return ContactScene(points, grids)


def _build(
    model: ReducedModel, grids: tuple[SignedDistanceGrid, ...], recordings: list[Trajectory], progress: Progress
) -> Arrays:
    points = select_collision_points(model.tongue, grids, _poses(model, recordings, progress))
    return {
        "nodes": points.nodes,
        "areas": points.areas,
        "seen_share": np.array(points.seen_share),
        "missed_depth": np.array(points.missed_depth),
    }


def _poses(model: ReducedModel, recordings: list[Trajectory], progress: Progress) -> Iterator[PosedNodes]:
    """Recorded poses with their jaw, then sampled ones with the jaw where it rests."""
    rng = np.random.default_rng(SEED)
    if recordings:
        yield from posed_recordings(model, recordings, RECORDED_POSES, rng, progress)
    equilibrium = coarse_equilibrium(model, rng)
    for displacement in sampled_displacements(model.tongue.sensor_rest_positions, SAMPLED_POSES, rng):
        coordinates = equilibrium(displacement)
        if coordinates is not None:
            yield nodes_of(model, coordinates), RigidPose()
