"""Several solvers on one trajectory: how far their surfaces are apart, and what each of them measured."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import StateHistory, TongueModel
from ..model.units import MM_PER_M
from .shape_distance import fitted_similarity, hausdorff_distance


@dataclass(frozen=True, eq=False)
class SolverRun:
    """One solver's run. label: unique name; dof_count: its unknowns; history: all frames of the trajectory."""

    label: str
    dof_count: int
    history: StateHistory


@dataclass(frozen=True, eq=False)
class SurfaceDistance:
    """Distance of one run's surface from the reference's, per frame [mm], each (frame_count,).

    mean, maximum: over corresponding surface nodes. hausdorff: after the best rotation and scale (Luo 2017,
    section 9). relative: hausdorff over the diagonal of the resting surface's bounding box [-].
    """

    mean: NDArray[np.float64]
    maximum: NDArray[np.float64]
    hausdorff: NDArray[np.float64]
    relative: NDArray[np.float64]


def surface_distance(tongue: TongueModel, run: SolverRun, reference: SolverRun) -> SurfaceDistance:
    """The run against the reference in every frame that both have, which are the same trajectory's."""
    boundary, triangles = tongue.mesh.boundary_nodes, tongue.mesh.boundary_triangles
    diagonal = MM_PER_M * float(np.linalg.norm(np.ptp(tongue.mesh.nodes[boundary], axis=0)))
    count = min(run.history.frame_count, reference.history.frame_count)
    mean, maximum, hausdorff = np.empty(count), np.empty(count), np.empty(count)
    for frame, time in enumerate(reference.history.time[:count]):
        ours, theirs = (r.history.sample(time).nodes.astype(np.float64) for r in (run, reference))
        apart = MM_PER_M * np.linalg.norm(ours[boundary] - theirs[boundary], axis=1)
        mean[frame], maximum[frame] = apart.mean(), apart.max()
        aligned = fitted_similarity(ours[boundary], theirs[boundary]).apply(ours)
        hausdorff[frame] = MM_PER_M * hausdorff_distance(aligned, theirs, triangles)
    return SurfaceDistance(mean, maximum, hausdorff, hausdorff / diagonal)


def node_distance(run: SolverRun, reference: SolverRun, time: float) -> NDArray[np.float64]:
    """Distance of corresponding nodes [mm] at one time [s], (node_count,)."""
    apart = run.history.sample(time).nodes - reference.history.sample(time).nodes
    return MM_PER_M * np.linalg.norm(apart.astype(np.float64), axis=1)


def most_different_time(run: SolverRun, reference: SolverRun, distance: SurfaceDistance) -> float:
    """Time [s] of the frame in which the surfaces are farthest apart on average."""
    return float(reference.history.time[int(distance.mean.argmax())])
