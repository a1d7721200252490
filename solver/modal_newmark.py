"""One step of the decoupled modal equations by Newmark's average acceleration, held to the sensors.

q'' + C q' + K q = f + J(q)^T multipliers, C and K diagonal, r(q) = target at the end of the step, where r is the
warped displacement of the imposed sensor coordinates and J its Jacobian (Yang 2013, section 4, Eq. 2 and 3).

Average acceleration (beta = 1/4, gamma = 1/2; Hughes 2000) means q1 - q0 = h (v0 + v1) / 2 and
v1 - v0 = h (a0 + a1) / 2. With the equations of motion put in for a0 and a1 and d = q1 - q0 this is

    (2/h^2 + C/h + K/2) d = f - K q0 + 2 v0/h + mean(J^T multipliers),

so accelerations need not be carried from step to step. The mean force of the sensors acts along the mean of J at
both ends, which keeps the second order under moving sensors.

Departure from the paper: as it stands, average acceleration lets the velocity of an imposed coordinate swing
about its true value for ever after a jump, and the sensor forces with it. So the end velocity is projected onto
J v1 = J d / h, in the mass norm. The impulse of that is counted in the sensor forces: momentum is balanced.
"""

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import lapack

from .protocol import StepReport
from .warped_sensors import WarpedSensors

GAP_TOLERANCE = 1e-7
"""Distance of a sensor from its target that is small enough [m]: a hundredth of what is promised."""
TOLERANCE = 1e-3
"""Relative change that another iteration would make to what the sensors do to the modes in a step."""
MAXIMUM_ITERATIONS = 20
NEAR = 1e-3
"""A gap below which Newton's method closes it by itself, so that it may grow [m]."""
HALVINGS = 5
ACCELERATED_FROM = 3
"""Iteration from which Anderson's acceleration helps; speech needs two or three."""

Vector = NDArray[np.float64]


class _Place(NamedTuple):
    """Modal coordinates q, and there target - r(q), J(q) and the largest gap [m]."""

    q: Vector
    gap: Vector
    jacobian: NDArray[np.float64]
    largest_gap: float


class ModalNewmark:
    """Advances modal coordinates under sensor constraints.

    eigenvalues [1/s^2], damping [1/s]: the diagonals of K and C, (mode_count,). sensors: the warp at the sensors.
    tolerance: as TOLERANCE.
    """

    def __init__(
        self, eigenvalues: Vector, damping: Vector, sensors: WarpedSensors, tolerance: float = TOLERANCE
    ) -> None:
        self._tolerance = tolerance
        self._eigenvalues, self._damping, self._sensors = eigenvalues, damping, sensors
        self._dt = 0.0

    def advance(
        self, start: Vector, velocity: Vector, load: Vector, imposed: NDArray[np.intp], target: Vector, dt: float,
        report: StepReport,
    ) -> tuple[Vector, Vector, Vector]:  # fmt: skip
        """Modal coordinates and velocities (mode_count,) after `dt` [s], and the mean sensor forces [N].

        start, velocity: at the start. load: modal force. imposed: which of the 3 sensor_count coordinates are;
        target and the forces: one for each of them. `report` is filled.
        """
        if dt != self._dt:
            self._inverse = 1.0 / (2.0 / dt**2 + self._damping / dt + 0.5 * self._eigenvalues)
            self._half_inverse = 0.5 * self._inverse
            self._dt = dt
        free = start + self._inverse * (load - self._eigenvalues * start + (2.0 / dt) * velocity)
        report.iterations, report.residual, report.converged = 1, 0.0, True
        if len(imposed) == 0:
            return free, (2.0 / dt) * (free - start) - velocity, np.zeros(0)
        try:
            end, forces, jacobian = self._hold(start, free, imposed, target, report)
            rate = (end - start) / dt
            swinging = 2.0 * rate - velocity
            impulse = _solve(jacobian @ jacobian.T, jacobian @ (rate - swinging))
        except np.linalg.LinAlgError:
            report.converged, report.residual = False, np.inf
            return free, (free - start) / dt, np.zeros(len(imposed))
        return end, swinging + impulse @ jacobian, forces + impulse / dt

    def _hold(
        self, start: Vector, free: Vector, imposed: NDArray[np.intp], target: Vector, report: StepReport
    ) -> tuple[Vector, Vector, NDArray]:
        """The constrained end of the step, by Newton's method on the warp: q, multipliers, J.

        free: where the step ends without sensors. The constraints' curvature is left out of the matrix, so
        the gap falls quadratically but the direction of the forces settles linearly.
        """
        here = first = self._evaluate(start, imposed, target)
        compliance = first.jacobian * self._inverse
        points: list[Vector] = []
        steps: list[Vector] = []
        for iteration in range(1, MAXIMUM_ITERATIONS + 1):
            report.iterations = iteration
            right = here.gap + here.jacobian @ (here.q - free)
            multipliers = _solve(here.jacobian @ compliance.T, right)
            points.append(here.q)
            steps.append(free + multipliers @ compliance - here.q)
            step = steps[-1] if iteration < ACCELERATED_FROM else _accelerated(points[-3:], steps[-3:])
            here = self._shortened(here, step, imposed, target)
            compliance = (first.jacobian + here.jacobian) * self._half_inverse
            change, moved = free + multipliers @ compliance - here.q, here.q - free
            report.residual = math.sqrt(float(change @ change) / max(float(moved @ moved), 1e-24))
            report.converged = here.largest_gap <= GAP_TOLERANCE and report.residual <= self._tolerance
            if report.converged or not math.isfinite(report.residual):
                break
        return here.q, multipliers, here.jacobian

    def _shortened(self, here: _Place, step: Vector, imposed: NDArray[np.intp], target: Vector) -> _Place:
        """The place a whole, half, ... step away: the longest that does not let the gap grow."""
        bound = max(here.largest_gap, NEAR)
        length = 1.0
        for _ in range(HALVINGS):
            there = self._evaluate(here.q + length * step, imposed, target)
            if there.largest_gap <= bound:
                break
            length *= 0.5
        return there

    def _evaluate(self, q: Vector, imposed: NDArray[np.intp], target: Vector) -> _Place:
        self._sensors.evaluate(q)
        gap = target - self._sensors.displacement[imposed]
        return _Place(q, gap, self._sensors.jacobian.take(imposed, axis=0), float(np.abs(gap).max()))


def _accelerated(points: list[Vector], steps: list[Vector]) -> Vector:
    """Step of Anderson's acceleration (1965) from the last of the points, given the plain step from each.

    The direction of the sensor forces turns with the shape. After a jump of centimetres the plain iteration
    overshoots it every time, a little more or a little less: combined, two such steps meet.
    """
    step_changes = np.diff(steps, axis=0).T
    changes = np.diff(points, axis=0).T + step_changes
    return steps[-1] - changes @ np.linalg.lstsq(step_changes, steps[-1])[0]


def _solve(matrix: NDArray, right: Vector) -> Vector:
    """matrix^-1 right; a fifth of the time of numpy.linalg.solve for a dozen unknowns.

    Raises numpy.linalg.LinAlgError when the matrix is singular.
    """
    _, _, solution, info = lapack.dgesv(matrix, right)
    if info != 0:
        raise np.linalg.LinAlgError("the sensor constraints repeat each other")
    return solution
