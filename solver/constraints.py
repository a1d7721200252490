"""Sensor rows: which coordinates of which sensors are imposed, and on what value."""

import numpy as np
from numpy.typing import NDArray

from ..model import Control, LingualError, TongueModel

RANK_TOLERANCE = 1e-9
"""Relative singular value below which a row repeats the others: sensors on one node do."""


def row_space(rows: NDArray[np.floating]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Of constraint rows (c, n): an orthonormal basis (r, n) of their space, r <= c the rank, and (c, r) factors.

    A force with components f along the basis is that of the multipliers factors @ f along the rows.
    """
    left, singular, right = np.linalg.svd(rows, full_matrices=False)
    kept = singular > RANK_TOLERANCE * singular.max(initial=0.0)
    return np.ascontiguousarray(right[kept]), left[:, kept] / singular[kept]


def null_projector(basis: NDArray[np.floating]) -> NDArray[np.float64]:
    """Orthogonal projection (n, n) on what is across an orthonormal basis (r, n) of a row space."""
    projector: NDArray[np.float64] = np.eye(basis.shape[1]) - basis.T @ basis
    return projector


class SensorConstraints:
    """Constraint rows J in the solver's unknowns, J x = target - rest, for the coordinates imposed now.

    sensor_rows: (sensor_count, m): sensor displacement = sensor_rows @ u for unknowns u (m, 3). The flat
    unknown 3 k + i is component i of row k.
    """

    def __init__(self, tongue: TongueModel, sensor_rows: NDArray[np.floating]) -> None:
        self._rest = tongue.sensor_rest_positions
        self._all_rows = np.kron(sensor_rows, np.eye(3, dtype=sensor_rows.dtype))
        self._names = tongue.sensors.names
        self._selected: NDArray[np.bool_] = np.zeros(len(self._all_rows), dtype=bool)
        self.rows = self._all_rows[:0]
        self.target = np.zeros(0)

    def set_control(self, control: Control) -> bool:
        """Takes the targets of a step; True when other coordinates are imposed than before.

        Raises LingualError, naming the sensor, for a target that is not finite.
        """
        selected = control.sensor_constrained.ravel()
        displacement = (control.sensor_targets - self._rest).ravel()[selected]
        if not np.isfinite(displacement).all():
            bad = np.flatnonzero(selected)[~np.isfinite(displacement)][0]
            raise LingualError(
                f"The target of sensor {self._names[bad // 3]} along {'xyz'[bad % 3]} is not a finite number; "
                "bridge drop-outs in the recording first."
            )
        changed = not np.array_equal(selected, self._selected)
        if changed:
            self._selected = selected.copy()
            self.rows = np.ascontiguousarray(self._all_rows[selected])
        self.target = displacement.astype(self.rows.dtype)
        return changed

    def forces(self, multipliers: NDArray[np.floating]) -> NDArray[np.float64]:
        """Force on each sensor [N], (sensor_count, 3), zero along coordinates that are not imposed."""
        forces = np.zeros(len(self._all_rows))
        forces[self._selected] = -multipliers
        return forces.reshape(-1, 3)
