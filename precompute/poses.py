"""Training poses: reduced coordinates the tongue visits when its sensors move.

Sensor displacements come from recordings where there are any and are sampled otherwise; each is
imposed on a static equilibrium in the subspace, over a coarse set of elements, which is good enough
to know where cubature must be accurate.
"""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..model import ReducedModel, Trajectory
from ..model.reduced_forces import ReducedForces
from ..model.reduced_model import gradient_operator
from ..model.saddle_point import solve_saddle_point
from .progress import Progress, silent

COARSE_ELEMENTS = 1500
SAMPLED_STANDARD_DEVIATION = np.array([4.0, 1.5, 4.0]) * 1e-3
"""Sampled sensor displacement [m] along x, y, z: recordings of speech reach 17 mm (four deviations)."""
CORRELATION_LENGTH = 20e-3
"""Distance [m] over which sampled displacements of neighbouring sensors resemble each other."""
EQUILIBRIUM_ITERATIONS = 12
EQUILIBRIUM_TOLERANCE = 1e-4


def sampled_displacements(rest: NDArray[np.float64], count: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Random smooth displacements (count, sensor_count, 3) [m] of sensors at `rest`.

    Gaussian, correlated along the tongue, with a random overall size so that small poses, where the
    response is linear, are seen as well as large ones.
    """
    distance = np.linalg.norm(rest[:, None] - rest[None], axis=2)
    root = np.linalg.cholesky(np.exp(-0.5 * (distance / CORRELATION_LENGTH) ** 2) + 1e-6 * np.eye(len(rest)))
    normal = rng.standard_normal((count, len(rest), 3))
    size = rng.uniform(0.1, 1.3, (count, 1, 1))
    return size * np.einsum("st,ntc->nsc", root, normal) * SAMPLED_STANDARD_DEVIATION


def recorded_displacements(
    recordings: list[Trajectory], rest: NDArray[np.float64], count: int
) -> NDArray[np.float64]:
    """Sensor displacements (count or fewer, sensor_count, 3) [m] at evenly spaced recorded frames.

    recordings: fitted to the sensors, in their order (NaN where not measured becomes 0).
    """
    frames = np.concatenate([r.positions - rest for r in recordings])
    chosen = np.linspace(0, len(frames) - 1, min(count, len(frames))).astype(int)
    return np.nan_to_num(frames[chosen], nan=0.0)


def equilibrium_poses(
    model: ReducedModel,
    displacements: NDArray[np.float64],
    rng: np.random.Generator,
    progress: Progress = silent,
) -> NDArray[np.float64]:
    """Reduced coordinates (pose_count, columns, 3) of static equilibria with the sensors displaced.

    displacements: (n, sensor_count, 3) [m]. A target that has no equilibrium (the coarse elements
    collapse) is left out, so pose_count may be less than n.
    """
    equilibrium = coarse_equilibrium(model, rng)
    poses = []
    for n, displacement in enumerate(displacements):
        progress("training poses", n / len(displacements))
        pose = equilibrium(displacement)
        if pose is not None and pose.any():  # the pose at rest has no force to be approximated
            poses.append(pose)
    progress("training poses", 1.0)
    return np.array(poses)


def coarse_equilibrium(
    model: ReducedModel, rng: np.random.Generator
) -> Callable[[NDArray[np.float64]], NDArray[np.float64] | None]:
    """Function from sensor displacements (sensor_count, 3) [m] to reduced coordinates (columns, 3), or None.

    The equilibrium over COARSE_ELEMENTS random elements; None where there is none.
    """
    mesh = model.tongue.mesh
    count = min(COARSE_ELEMENTS, mesh.tet_count)
    chosen = rng.choice(mesh.tet_count, count, replace=False, p=mesh.volumes / mesh.volume)
    weights = np.full(count, mesh.volume / count)
    forces = ReducedForces(model.tongue.material, gradient_operator(model.tongue, model.basis, chosen), weights)
    rows = np.kron(model.sensor_rows, np.eye(3))
    return lambda displacement: _equilibrium(forces, rows, displacement.ravel())


def _equilibrium(
    forces: ReducedForces, rows: NDArray[np.floating], target: NDArray[np.float64]
) -> NDArray[np.float64] | None:
    """Newton's method from rest; None when it does not settle or turns elements inside out."""
    coordinates = np.zeros((forces.column_count, 3))
    for _ in range(EQUILIBRIUM_ITERATIONS):
        forces.set_coordinates(coordinates)
        force = forces.force().ravel()
        gap = target - rows @ coordinates.ravel()
        step, _ = solve_saddle_point(forces.stiffness(), rows, -force, gap)
        coordinates = coordinates + step.reshape(-1, 3)
        if not np.isfinite(coordinates).all():
            return None
        if np.linalg.norm(step) <= EQUILIBRIUM_TOLERANCE * np.linalg.norm(coordinates):
            forces.set_coordinates(coordinates)
            return coordinates if forces.elements.energy_density()[1].min() > 0.0 else None
    return None
