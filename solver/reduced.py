"""SolverReduced: implicit Euler in the blended quadratic subspace (Luo 2017, section 6)."""

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from ..kernels.precision import precision
from ..model import Control, ReducedModel, State
from ..model.reduced_forces import ReducedForces
from ..model.saddle_point import solve_saddle_point
from . import newton
from .constraints import SensorConstraints
from .projected_cg import LaggedPreconditioner, Solve, projected_cg
from .protocol import StepReport

AGED_ITERATIONS = 4
"""A new factor costs about thirty products with the stiffness."""


class SolverReduced:
    """Newton on 3 x column_count unknowns, forces by cubature, sensors by Lagrange multipliers.

    model: the subspace. precision_name: "float64" or "float32". tolerance: relative residual.
    The basis is mass-orthonormal, so the reduced mass is the identity.
    """

    name = "reduced"

    def __init__(
        self, model: ReducedModel, precision_name: str = "float64", tolerance: float = newton.TOLERANCE
    ) -> None:
        self.model = model
        self.tongue = model.tongue
        self.report = StepReport()
        self.tolerance = tolerance
        self._precision = precision(precision_name)
        self._problem = _ReducedStep(model, precision_name)
        dtype = self._precision.numpy
        self._rest = self.tongue.mesh.nodes.astype(dtype)
        self._basis = model.basis.astype(dtype)

    @property
    def dof_count(self) -> int:
        return self.model.dof_count

    def new_state(self) -> State:
        nodes, columns = self.tongue.mesh.node_count, self.model.column_count

        def zeros(count: int) -> wp.array:
            return wp.zeros(count, dtype=self._precision.vec3, device="cpu")

        return State(
            time=0.0,
            position=wp.array(self._rest, dtype=self._precision.vec3, device="cpu"),
            velocity=zeros(nodes),
            coordinates=zeros(columns),
            coordinate_velocity=zeros(columns),
            sensor_force=zeros(self.tongue.sensors.count),
        )

    def step(self, state_in: State, state_out: State, control: Control, dt: float) -> None:
        start, velocity = state_in.coordinates.numpy(), state_in.coordinate_velocity.numpy()
        problem = self._problem
        problem.begin(start, velocity, control, dt)
        x, multipliers = newton.solve_step(problem, start.ravel().copy(), self.report, self.tolerance)
        coordinates = state_out.coordinates.numpy()
        coordinates[:] = x.reshape(-1, 3)
        coordinate_velocity = state_out.coordinate_velocity.numpy()
        np.divide(coordinates - start, dt, out=coordinate_velocity)
        self._fill_nodes(state_in, state_out, coordinates, dt)
        state_out.sensor_force.numpy()[:] = problem.constraints.forces(multipliers)
        state_out.time = state_in.time + dt

    def _fill_nodes(self, state_in: State, state_out: State, coordinates: NDArray, dt: float) -> None:
        position, velocity = state_out.position.numpy(), state_out.velocity.numpy()
        np.matmul(self._basis, coordinates, out=position)
        position += self._rest
        np.subtract(position, state_in.position.numpy(), out=velocity)
        velocity /= dt


class _ReducedStep:
    """The equations of one reduced step (a newton.StepProblem)."""

    def __init__(self, model: ReducedModel, precision_name: str) -> None:
        material = model.tongue.material
        self.forces = ReducedForces(
            material, model.gradient_operator, model.cubature_weights, precision_name
        )
        dtype = self.forces.elements.precision.numpy
        self.constraints = SensorConstraints(model.tongue, model.sensor_rows.astype(dtype))
        self._damping_mass = material.damping_mass
        self._mass = float(model.tongue.node_masses.sum())
        self._preconditioner = LaggedPreconditioner(AGED_ITERATIONS)
        # B^T M 1, the reduced force of a unit acceleration of all nodes.
        self._unit_load = (model.basis.T @ model.tongue.node_masses).astype(dtype)

    def begin(self, start: NDArray, velocity: NDArray, control: Control, dt: float) -> None:
        """Fixes the data of one step; the damping refers to the start's displacement gradients."""
        self._start = start.ravel()
        self._velocity = velocity.ravel()
        self._load = np.outer(self._unit_load, control.gravity).ravel().astype(start.dtype)
        self._preconditioner.begin_step(dt, self.constraints.set_control(control))
        self._dt = dt
        self._scale = newton.smallest_scale(self._mass, dt)
        self.forces.set_coordinates(start)
        self.forces.elements.begin_step()

    def residual(self, x: NDArray) -> tuple[NDArray, float]:
        self.forces.set_coordinates(x.reshape(-1, 3))
        rate = (x - self._start) / self._dt
        inertia = (rate - self._velocity) / self._dt
        internal = self.forces.force(self._dt).ravel()
        residual = inertia + self._damping_mass * rate + internal - self._load
        return residual, max(float(np.linalg.norm(inertia)), float(np.linalg.norm(internal)), self._scale)

    def gap(self, x: NDArray) -> NDArray:
        return self.constraints.target - self.constraints.rows @ x

    def newton_step(self, x: NDArray, residual: NDArray, gap: NDArray) -> tuple[NDArray, NDArray]:
        self.forces.elements.evaluate_tangent(self._dt)
        try:
            return projected_cg(
                self._product, self._factorise, self.constraints.rows, -residual, gap, self._preconditioner
            )
        except np.linalg.LinAlgError:  # indefinite: dense and exact
            self._preconditioner.forget()
            return solve_saddle_point(self._matrix(), self.constraints.rows, -residual, gap)

    @property
    def _shift(self) -> float:
        return 1.0 / self._dt**2 + self._damping_mass / self._dt

    def _product(self, direction: NDArray) -> NDArray:
        product = self.forces.apply_stiffness(direction.reshape(-1, 3)).ravel()
        product += self._shift * direction
        return product

    def _matrix(self) -> NDArray:
        A = self.forces.stiffness(self._dt)
        diagonal = np.einsum("ii->i", A)
        diagonal += self._shift
        return A

    def _factorise(self) -> Solve:
        """The inverse itself: one product with it costs less than two triangular solves, and it is rarely made."""
        inverse = cho_solve(cho_factor(self._matrix()), np.eye(3 * self.forces.column_count))
        return inverse.astype(self._start.dtype).__matmul__

    def dual_norm(self, residual: NDArray, multipliers: NDArray) -> float:
        return float(np.linalg.norm(residual + self.constraints.rows.T @ multipliers))
