"""SolverReduced: implicit Euler in the blended quadratic subspace (Luo 2017, section 6), one tongue."""

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.precision import precision
from ..model import Control, ReducedModel, State
from ..model.contact_scene import ContactScene
from ..model.volume_pressure import PressureSubspace
from . import newton
from .constraints import SensorConstraints
from .protocol import StepReport
from .tongue_batch import TongueBatch


class SolverReduced:
    """3 x column_count unknowns, forces by cubature, sensors by Lagrange multipliers.

    model: the subspace. precision_name: "float64" or "float32" (which reaches a tolerance of about 1e-6).
    tolerance: relative residual. contact: the mouth around it, None for none.
    pressure: subspace in which the volume is corrected after every step, None for no correction.
    The basis is mass-orthonormal, so the reduced mass is the identity.
    """

    name = "reduced"

    def __init__(
        self,
        model: ReducedModel,
        precision_name: str = "float64",
        tolerance: float = newton.TOLERANCE,
        contact: ContactScene | None = None,
        pressure: PressureSubspace | None = None,
    ) -> None:
        self.model = model
        self.tongue = model.tongue
        self.report = StepReport()
        self.tolerance = tolerance
        self._precision_name = precision_name
        self._precision = precision(precision_name)
        self._constraints = SensorConstraints(self.tongue, model.sensor_rows)
        self._contact, self._pressure = contact, pressure
        self._batches: dict[bytes, TongueBatch] = {}

    @property
    def dof_count(self) -> int:
        return self.model.dof_count

    @property
    def volume_mode(self) -> str:
        return "subspace" if self._pressure else "none"

    @property
    def contact_point_count(self) -> int:
        return len(self._contact.points.nodes) if self._contact else 0

    def new_state(self) -> State:
        nodes, columns = self.tongue.mesh.node_count, self.model.column_count

        def zeros(count: int) -> wp.array:
            return wp.zeros(count, dtype=self._precision.vec3, device="cpu")

        return State(
            time=0.0,
            position=wp.array(self.tongue.mesh.nodes, dtype=self._precision.vec3, device="cpu"),
            velocity=zeros(nodes),
            coordinates=zeros(columns),
            coordinate_velocity=zeros(columns),
            sensor_force=zeros(self.tongue.sensors.count),
        )

    def step(self, state_in: State, state_out: State, control: Control, dt: float) -> None:
        self._constraints.set_control(control)
        batch = self._batch(control.sensor_constrained)
        batch.set_time_step(dt)
        batch.set_gravity(control.gravity)
        batch.set_jaw_poses(control.jaw_pose)
        batch.set_targets(self._constraints.target)
        coordinates, velocity = batch.coordinates.numpy(), batch.velocity.numpy()
        coordinates[:, :, 0] = state_in.coordinates.numpy()
        velocity[:, :, 0] = state_in.coordinate_velocity.numpy()
        batch.step()
        state_out.coordinates.numpy()[:] = coordinates[:, :, 0]
        state_out.coordinate_velocity.numpy()[:] = velocity[:, :, 0]
        _fill_nodes(state_in, state_out, batch.position.numpy()[:, :, 0], dt)
        state_out.sensor_force.numpy()[:] = self._constraints.forces(-batch.constraint_forces()[:, 0])
        state_out.time = state_in.time + dt
        self.report.iterations = batch.evaluations
        self.report.residual = float(batch.errors[0])
        self.report.converged = bool(batch.converged[0])

    def _batch(self, constrained: NDArray[np.bool_]) -> TongueBatch:
        """The batch of one that imposes these sensor coordinates, made when they are first asked for."""
        key = np.packbits(constrained).tobytes()
        if key not in self._batches:
            self._batches[key] = TongueBatch(
                self.model,
                constrained,
                precision_name=self._precision_name,
                tolerance=self.tolerance,
                contact=self._contact,
                pressure=self._pressure,
            )
        return self._batches[key]


def _fill_nodes(state_in: State, state_out: State, nodes: NDArray[np.floating], dt: float) -> None:
    position, velocity = state_out.position.numpy(), state_out.velocity.numpy()
    position[:] = nodes
    np.subtract(position, state_in.position.numpy(), out=velocity)
    velocity /= dt
