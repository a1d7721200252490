"""Full-space volume correction of a solver's state after a step: the reference of the subspace correction.

Positions and velocities are corrected as model/volume_correction.py says. The corrected shape of a reduced solver
leaves its subspace: its coordinates become the mass-orthogonal projection, from which the next step starts.
"""

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..model import State, TongueModel
from ..model.volume import COMPLIANCE_LENGTH
from ..model.volume_correction import NEWTON_ITERATIONS, VolumeCorrection, VolumeReport


class VolumeFullSpace:
    """Corrects the states of one tongue, on the CPU.

    constrained: (sensor_count, 3) bool, sensor coordinates that stay where they are. basis: B of a reduced solver,
    (node_count, columns), mass-orthonormal; None for a solver without coordinates. compliance_length: [m].
    """

    def __init__(
        self,
        tongue: TongueModel,
        constrained: NDArray[np.bool_],
        basis: NDArray[np.float64] | None = None,
        compliance_length: float = COMPLIANCE_LENGTH,
    ) -> None:
        self._correction = VolumeCorrection(tongue, constrained, compliance_length)
        self._rest = tongue.mesh.nodes
        self._projection = None if basis is None else np.ascontiguousarray((basis * tongue.node_masses[:, None]).T)

    @property
    def report(self) -> VolumeReport:
        return self._correction.report

    def correct(self, state: State, iterations: int = NEWTON_ITERATIONS) -> None:
        """Overwrites position and velocity, and coordinates and their rate where there is a basis."""
        position = self._correction.correct_positions(state.position.numpy(), iterations)
        velocity = self._correction.correct_velocities(position, state.velocity.numpy())
        _assign(state.position, position)
        _assign(state.velocity, velocity)
        if self._projection is not None:
            _assign(state.coordinates, self._projection @ (position - self._rest))
            _assign(state.coordinate_velocity, self._projection @ velocity)


def _assign(array: wp.array, values: NDArray[np.float64]) -> None:
    array.assign(np.ascontiguousarray(values))
