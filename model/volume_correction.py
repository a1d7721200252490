"""Full-space volume correction of positions and velocities (Luo 2017, Eq. 16; Irving, Schroeder and Fedkiw 2007).

After a step, the positions of all free nodes move by the dx that minimises

    rho^-1 |dx|_M^2 + l^2 sum_e V_e (J_e - 1 + D_e dx / V_e)^2   subject to   R dx = 0,   1^T D dx = V0 - V,

with J_e = det F of element e, D the discrete divergence, R the imposed sensor rows, l the compliance length.
In pressures this is (D M^-1 D^T + diag(V_e / (rho l^2))) p = V - V0, dx = -M^-1 D^T p, in the sensors' null space:
one pressure an element, with a small compliance. Velocities are made divergence-free in the same way.

Departures: with rigid constraints (no compliance) there are more pressures than free unknowns and no solution;
Irving's remedy, one pressure a node, was measured and spoils single elements (docs/design/volume.md). The whole
volume is nevertheless met exactly, through a uniform pressure whose displacement is computed once, at rest.

The equations are solved for dx, by conjugate gradients in the sensors' null space with a diagonal preconditioner:
six times faster than with a factor of the rest shape's matrix, which needs as many iterations at a deformed shape.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from .tongue_model import TongueModel
from .volume import COMPLIANCE_LENGTH, ElementVolumes

NEWTON_ITERATIONS = 2
TOLERANCE = 1e-2
"""Reduction of the preconditioned residual in one linear solution; Newton's next iteration sees the rest."""
UNIFORM_TOLERANCE = 1e-4
"""The same for the displacement of a uniform pressure, which is solved for once."""
MAXIMUM_ITERATIONS = 500


@dataclass
class VolumeReport:
    """Of the last position correction: Newton iterations and the drift (V - V0) / V0 after it.

    linear_iterations: of conjugate gradients, those of a velocity correction that followed included.
    """

    newton_iterations: int = 0
    linear_iterations: int = 0
    drift: float = 0.0


class VolumeCorrection:
    """Corrects node positions and velocities of one tongue.

    constrained: (sensor_count, 3) bool, sensor coordinates that stay where they are.
    compliance_length: l [m].

    pressure: of the last position correction [kg/m], a pressure times the square of a time, (tet_count,): the sum
    over its Newton iterations of p in dx = -M^-1 D^T p.
    """

    def __init__(
        self,
        tongue: TongueModel,
        constrained: NDArray[np.bool_],
        compliance_length: float = COMPLIANCE_LENGTH,
    ) -> None:
        self.tongue = tongue
        self.report = VolumeReport()
        self.pressure = np.zeros(tongue.mesh.tet_count)
        self._free = tongue.free_nodes
        self._elements = ElementVolumes(tongue.mesh, self._free)
        self._mass = np.repeat(tongue.node_masses[self._free], 3)
        self._stiffness = tongue.material.density * compliance_length**2 / tongue.mesh.volumes
        rows = sp.kron(tongue.sensors.weights[:, self._free], sp.eye_array(3)).tocsr()
        self._rows = rows[np.flatnonzero(constrained.ravel())].toarray()
        self._set_preconditioner()
        self._uniform = self._conjugate_gradients(self._surface_vectors(), UNIFORM_TOLERANCE)

    def _set_preconditioner(self) -> None:
        """Takes the diagonal of the present shape's matrix, with the sensor rows' Schur complement."""
        D = self._elements.divergence
        diagonal = self._mass + D.multiply(D).T @ self._stiffness
        self._inverse_diagonal = 1.0 / diagonal
        self._solved_rows = self._inverse_diagonal[:, None] * self._rows.T
        self._schur = np.linalg.pinv(self._rows @ self._solved_rows)

    def _precondition(self, residual: NDArray) -> NDArray:
        """The diagonal matrix's solution in the null space of the sensor rows."""
        x = self._inverse_diagonal * residual
        return x - self._solved_rows @ (self._schur @ (self._rows @ x))

    def correct_positions(
        self, nodes: NDArray[np.floating], iterations: int = NEWTON_ITERATIONS
    ) -> NDArray[np.float64]:
        """Corrected positions (node_count, 3) [m] of nodes (node_count, 3); sensors and fixed nodes stay."""
        corrected = np.array(nodes, dtype=np.float64)
        elements, rest = self._elements, self.tongue.mesh.volumes
        self.pressure[:] = 0.0
        self.report = VolumeReport(newton_iterations=iterations)
        for _ in range(iterations):
            elements.set_positions(corrected)
            dx, pressure = self._correction(elements.volumes - rest)
            self.pressure += pressure
            corrected[self._free] += dx.reshape(-1, 3)
        elements.set_positions(corrected)
        self.report.drift = float(elements.volumes.sum()) / self.tongue.mesh.volume - 1.0
        return corrected

    def correct_velocities(self, nodes: NDArray[np.floating], velocity: NDArray[np.floating]) -> NDArray[np.float64]:
        """Velocities (node_count, 3) [m/s] made as divergence-free as the compliance lets them, at shape `nodes`."""
        corrected = np.array(velocity, dtype=np.float64)
        elements = self._elements
        elements.set_positions(nodes)
        change, _ = self._correction(elements.divergence @ corrected[self._free].ravel())
        corrected[self._free] += change.reshape(-1, 3)
        return corrected

    def _correction(self, excess: NDArray) -> tuple[NDArray, NDArray]:
        """dx (3 free,) and pressures (tet_count,) for excess volumes (tet_count,), at the shape set last."""
        D, weight = self._elements.divergence, self._stiffness
        self._set_preconditioner()
        dx = self._conjugate_gradients(-(D.T @ (weight * excess)), TOLERANCE)
        slope = self._surface_vectors()
        uniform = -(excess.sum() + slope @ dx) / (slope @ self._uniform)
        dx += uniform * self._uniform
        return dx, weight * (excess + D @ dx) - uniform

    def _surface_vectors(self) -> NDArray:
        """D^T 1: the gradient of the whole volume with respect to the free nodes, (3 free,)."""
        D = self._elements.divergence
        return D.T @ np.ones(D.shape[0])

    def _product(self, x: NDArray) -> NDArray:
        D = self._elements.divergence
        return self._mass * x + D.T @ (self._stiffness * (D @ x))

    def _conjugate_gradients(self, f: NDArray, tolerance: float) -> NDArray:
        """The minimiser of x.Ax/2 - f.x with sensor rows zero, A at the present shape."""
        x, residual = np.zeros_like(f), f.copy()
        p = z = self._precondition(residual)
        current = first = float(residual @ z)
        for _ in range(MAXIMUM_ITERATIONS):
            if current <= tolerance**2 * first or current <= 0.0:
                break
            self.report.linear_iterations += 1
            Ap = self._product(p)
            length = current / float(p @ Ap)
            x += length * p
            residual -= length * Ap
            z = self._precondition(residual)
            previous, current = current, float(residual @ z)
            p = z + (current / previous) * p
        return x
