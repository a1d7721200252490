"""Which surface nodes stand for the whole surface in contact, chosen from training motions (Luo 2017, Fig. 8).

Every free boundary node is tested against jaw and palate in every training pose. Of the nodes that were ever
inside, the deepest is taken first, then again and again the one farthest from all taken, until none is farther
than COVER from a taken one; then those whose penetrations no taken neighbour shares, deepest first. A touched
node's area belongs to the point nearest to it.
"""

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ..model import ReducedModel, RigidPose, TongueModel, Trajectory
from ..model.contact_depth import SurfacePenetration
from ..model.contact_forces import CollisionPoints
from ..model.signed_distance import SignedDistanceGrid
from ..model.units import M_PER_MM
from .poses import coarse_equilibrium
from .progress import Progress, silent

POINT_COUNT = 300
"""Points at most: the head needs about so many, the smaller mesh of ArtiSynth half of them."""
COVER = 2.5e-3
"""Farthest that a touched node may lie from a point [m]: about two edges of the medium mesh."""

PosedNodes = tuple[NDArray[np.float64], RigidPose]
"""Node positions (node_count, 3) [m] in the jaw frame, and the jaw's pose in the head."""


def posed_recordings(
    model: ReducedModel,
    recordings: list[Trajectory],
    count: int,
    rng: np.random.Generator,
    progress: Progress = silent,
) -> Iterator[PosedNodes]:
    """Equilibria at about `count` evenly spaced frames of trajectories fitted to the sensors, with their jaw.

    A frame without an equilibrium is left out.
    """
    equilibrium = coarse_equilibrium(model, rng)
    rest = model.tongue.sensor_rest_positions
    displacements = np.concatenate([np.nan_to_num(r.positions - rest) for r in recordings])
    jaw = np.concatenate([r.jaw_translation for r in recordings])
    frames = np.linspace(0, len(jaw) - 1, min(count, len(jaw))).astype(int)
    for n, frame in enumerate(frames):
        progress("contact poses", n / len(frames))
        coordinates = equilibrium(displacements[frame])
        if coordinates is not None:
            yield nodes_of(model, coordinates), RigidPose(translation=jaw[frame])


def nodes_of(model: ReducedModel, coordinates: NDArray[np.float64]) -> NDArray[np.float64]:
    """Node positions (node_count, 3) [m] at reduced coordinates (columns, 3)."""
    return model.tongue.mesh.nodes + model.basis @ coordinates


def select_collision_points(
    tongue: TongueModel,
    grids: tuple[SignedDistanceGrid, ...],
    poses: Iterable[PosedNodes],
    count: int = POINT_COUNT,
    cover: float = COVER,
) -> CollisionPoints:
    """At most `count` nodes that touch jaw or palate in the poses and stand for all that do.

    There are none when nothing is touched. `cover` [m]: distance between a touched node and a point.
    """
    surface = SurfacePenetration(tongue, grids)
    depths = np.array([M_PER_MM * surface.depths(nodes, jaw) for nodes, jaw in poses])
    depths = depths.reshape(-1, tongue.mesh.node_count)
    touched = np.flatnonzero(depths.max(axis=0, initial=0.0) > 0.0)
    if len(touched) == 0:
        return CollisionPoints(touched, np.zeros(0), 1.0, 0.0)
    depths, at = depths[:, touched], tongue.mesh.nodes[touched]
    chosen = _covering(depths.max(axis=0), at, count, cover)
    chosen = _completed(chosen, depths, at, count, cover)
    missed = _missed(chosen, depths, at, cover)
    _, nearest = cKDTree(at[chosen]).query(at)
    areas = np.bincount(nearest, weights=tongue.mesh.boundary_areas[touched], minlength=len(chosen))
    order = np.argsort(touched[chosen])
    return CollisionPoints(
        nodes=touched[chosen][order],
        areas=areas[order].astype(np.float64),
        seen_share=1.0 - np.count_nonzero(missed) / np.count_nonzero(depths),
        missed_depth=float(missed.max()),
    )


def _covering(deepest: NDArray[np.float64], at: NDArray[np.float64], count: int, cover: float) -> list[int]:
    """Farthest-point order from the deepest node on, until all are within `cover` or `count` are chosen."""
    chosen = [int(np.argmax(deepest))]
    distance = np.linalg.norm(at - at[chosen[0]], axis=1)
    while len(chosen) < count and distance.max() > cover:
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.linalg.norm(at - at[chosen[-1]], axis=1))
    return chosen


def _completed(
    chosen: list[int], depths: NDArray[np.float64], at: NDArray[np.float64], count: int, cover: float
) -> list[int]:
    """Adds the node of the deepest missed penetration until none is missed or `count` are chosen."""
    missed = _missed(chosen, depths, at, cover)
    while len(chosen) < count and missed.max() > 0.0:
        worst = int(np.argmax(missed.max(axis=0)))
        chosen = [*chosen, worst]
        near = np.linalg.norm(at - at[worst], axis=1) <= cover
        missed[np.ix_(depths[:, worst] > 0.0, near)] = 0.0
    return chosen


def _missed(
    chosen: list[int], depths: NDArray[np.float64], at: NDArray[np.float64], cover: float
) -> NDArray[np.float64]:
    """Depths (pose_count, touched_count) of nodes without a penetrating point within `cover`, else 0."""
    near = np.linalg.norm(at[:, None] - at[chosen][None], axis=2) <= cover
    seen = (depths[:, chosen] > 0.0).astype(np.float64) @ near.T.astype(np.float64) > 0.0
    return np.where(seen, 0.0, depths)
