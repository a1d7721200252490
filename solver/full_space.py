"""SolverFullSpace: implicit Euler on every free node, the reference that reduced solvers are held to."""

import numpy as np
import scipy.sparse as sp
import warp as wp
from numpy.typing import NDArray

from ..model import Control, State, TongueModel
from ..model.discretisation import Discretisation
from ..model.sparse_factor import factorise
from . import newton
from .constraints import SensorConstraints
from .projected_cg import LaggedPreconditioner, projected_cg
from .protocol import StepReport


class SolverFullSpace:
    """Sparse Newton on 3 unknowns a free node, sensors by Lagrange multipliers.

    tongue: what is simulated. tolerance: relative residual in the mass norm, as for the reduced solver.
    The linear systems are solved by conjugate gradients in the constraints' null space, preconditioned
    by a factor of an earlier tangent, renewed when it has aged.
    """

    name = "full"

    def __init__(self, tongue: TongueModel, tolerance: float = newton.TOLERANCE) -> None:
        self.tongue = tongue
        self.report = StepReport()
        self.tolerance = tolerance
        self._problem = _FullStep(tongue)

    @property
    def dof_count(self) -> int:
        return 3 * len(self.tongue.free_nodes)

    def new_state(self) -> State:
        def zeros(count: int) -> wp.array:
            return wp.zeros(count, dtype=wp.vec3d, device="cpu")

        return State(
            time=0.0,
            position=wp.array(self.tongue.mesh.nodes, dtype=wp.vec3d, device="cpu"),
            velocity=zeros(self.tongue.mesh.node_count),
            coordinates=zeros(0),
            coordinate_velocity=zeros(0),
            sensor_force=zeros(self.tongue.sensors.count),
        )

    def step(self, state_in: State, state_out: State, control: Control, dt: float) -> None:
        free, rest = self.tongue.free_nodes, self.tongue.mesh.nodes
        start = (state_in.position.numpy() - rest)[free]
        velocity = state_in.velocity.numpy()[free]
        self._problem.begin(start, velocity, control, dt)
        x, multipliers = newton.solve_step(self._problem, start.ravel().copy(), self.report, self.tolerance)
        displacement = x.reshape(-1, 3)
        position = state_out.position.numpy()
        position[:] = rest
        position[free] += displacement
        state_out.velocity.numpy()[free] = (displacement - start) / dt
        state_out.sensor_force.numpy()[:] = self._problem.constraints.forces(multipliers)
        state_out.time = state_in.time + dt


class _FullStep:
    """The equations of one full-space step (a newton.StepProblem)."""

    def __init__(self, tongue: TongueModel) -> None:
        self._free = tongue.free_nodes
        self._discretisation = Discretisation(tongue.mesh, tongue.material, self._free)
        self._nodal = np.zeros_like(tongue.mesh.nodes)
        self._mass = np.repeat(tongue.node_masses[self._free], 3)
        self._damping_mass = tongue.material.damping_mass
        sensor_rows = tongue.sensors.weights[:, self._free].toarray()
        self.constraints = SensorConstraints(tongue, sensor_rows)
        self._preconditioner = LaggedPreconditioner()

    def _set(self, x: NDArray) -> None:
        self._nodal[self._free] = x.reshape(-1, 3)
        self._discretisation.set_displacement(self._nodal)

    def begin(self, start: NDArray, velocity: NDArray, control: Control, dt: float) -> None:
        """Fixes the data of one step; the damping refers to the start's displacement gradients."""
        self._preconditioner.begin_step(dt, self.constraints.set_control(control))
        self._dt = dt
        self._scale = newton.smallest_scale(float(self._mass[::3].sum()), dt)
        self._start = start.ravel()
        self._velocity = velocity.ravel()
        self._load = self._mass * np.tile(control.gravity, len(self._free))
        self._set(start)
        self._discretisation.elements.begin_step()

    def residual(self, x: NDArray) -> tuple[NDArray, float]:
        self._set(x)
        rate = (x - self._start) / self._dt
        inertia = self._mass * (rate - self._velocity) / self._dt
        internal = self._discretisation.internal_force(self._dt)[self._free].ravel()
        residual = inertia + self._damping_mass * self._mass * rate + internal - self._load
        return residual, max(self._norm(inertia), self._norm(internal), self._scale)

    def gap(self, x: NDArray) -> NDArray:
        return self.constraints.target - self.constraints.rows @ x

    def newton_step(self, x: NDArray, residual: NDArray, gap: NDArray) -> tuple[NDArray, NDArray]:
        shift = self._mass * (1.0 / self._dt**2 + self._damping_mass / self._dt)
        A = (self._discretisation.stiffness(self._dt) + sp.diags_array(shift, format="bsr")).tocsr()
        return projected_cg(
            A.__matmul__, lambda: factorise(A).solve, self.constraints.rows, -residual, gap, self._preconditioner
        )

    def dual_norm(self, residual: NDArray, multipliers: NDArray) -> float:
        return self._norm(residual + self.constraints.rows.T @ multipliers)

    def _norm(self, force: NDArray) -> float:
        return float(np.sqrt(np.sum(force**2 / self._mass)))
