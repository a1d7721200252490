"""Key frames of speech and the pressures that volume needs there (Luo 2017, section 8, Eq. 16-17).

A key frame is a recorded frame of small finite-difference acceleration (s_{i+1} + s_{i-1} - 2 s_i) / (2 dt^2), the
smallest in each of as many equal stretches as there are key frames, so that they do not all fall into one pause.
For each, the static equilibrium with the sensors where they were is found in the displacement subspace; then volume
is restored in full space by Newton's method on Eq. 16, and the pressures of its iterations are summed.

Departure: the paper couples equilibrium and volume in Eq. 17, with K(u) in place of M. With M an iteration costs a
twentieth of a second instead of a factorisation, and its pressures belong to the operator that the correction of
a simulated step uses.
"""

import numpy as np
from numpy.typing import NDArray

from ..model import ReducedModel, Trajectory
from ..model.volume_correction import VolumeCorrection
from .poses import equilibrium_poses
from .progress import Progress, silent

NEWTON_ITERATIONS = 3


def key_displacements(
    recordings: list[Trajectory], rest: NDArray[np.float64], count: int
) -> NDArray[np.float64]:
    """Sensor displacements at `count` key frames, fewer where fewer were recorded, (n, sensor_count, 3) [m].

    recordings: fitted to the sensors, in their order. The first and last frame of each are never chosen.
    """
    displacements, accelerations = [], []
    for recording in recordings:
        s = np.nan_to_num(recording.positions - rest, nan=0.0)
        step = np.diff(recording.time)
        acceleration = (s[2:] + s[:-2] - 2.0 * s[1:-1]) / (2.0 * step[1:, None, None] * step[:-1, None, None])
        displacements.append(s[1:-1])
        accelerations.append(np.linalg.norm(acceleration, axis=(1, 2)))
    every = np.concatenate(accelerations) if accelerations else np.zeros(0)
    stretches = np.array_split(np.arange(len(every)), max(1, min(count, len(every))))
    chosen = [stretch[np.argmin(every[stretch])] for stretch in stretches if len(stretch)]
    return np.concatenate(displacements)[chosen] if chosen else np.zeros((0, *rest.shape))


def key_pressures(
    model: ReducedModel,
    displacements: NDArray[np.float64],
    compliance_length: float,
    rng: np.random.Generator,
    progress: Progress = silent,
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Reduced coordinates of the equilibria (n, columns, 3), and their pressures [kg/m], (n, tet_count).

    displacements: of the sensors, (m, sensor_count, 3) [m]; those without an equilibrium are left out.
    compliance_length: of the volume correction [m].
    """
    tongue = model.tongue
    poses = equilibrium_poses(model, displacements, rng, progress)
    correction = VolumeCorrection(tongue, np.ones((tongue.sensors.count, 3), dtype=bool), compliance_length)
    pressures = np.empty((len(poses), tongue.mesh.tet_count))
    for n, pose in enumerate(poses):
        progress("key frame pressures", n / len(poses))
        correction.correct_positions(tongue.mesh.nodes + model.basis @ pose, NEWTON_ITERATIONS)
        pressures[n] = correction.pressure
    progress("key frame pressures", 1.0)
    return poses, pressures


def orthonormal_basis(
    vectors: NDArray[np.float64], weights: NDArray[np.float64], count: int, remainder: float
) -> NDArray[np.float64]:
    """Modified Gram-Schmidt in the inner product of `weights`: P (m, k), k <= count, P^T diag(weights) P = I.

    vectors: (n, m). The first column is constant; then the vector with the largest remainder follows, until that is
    smaller than `remainder` times the largest at the start.
    """
    scaled = vectors * np.sqrt(weights)
    columns = [np.sqrt(weights / weights.sum())]
    scaled -= np.outer(scaled @ columns[0], columns[0])
    largest = np.linalg.norm(scaled, axis=1).max(initial=0.0)
    while len(columns) < count:
        lengths = np.linalg.norm(scaled, axis=1)
        if lengths.max(initial=0.0) <= max(remainder * largest, 1e-300):
            break
        column = scaled[np.argmax(lengths)]
        for _ in range(2):  # the second pass removes what rounding left
            for earlier in columns:
                column = column - (earlier @ column) * earlier
        column = column / np.linalg.norm(column)
        columns.append(column)
        scaled -= np.outer(scaled @ column, column)
    return np.stack(columns, axis=1) / np.sqrt(weights)[:, None]
