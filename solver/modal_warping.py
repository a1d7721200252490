"""SolverModalWarping: linear modes, warped by the rotations of the nodes (Yang 2013, section 4; Choi and Ko 2005).

The modal equations are integrated by `modal_newmark`. With their coordinates q, a = Phi q is the linear
displacement and w = Psi q = W a the rotation vector of the nodes, and a node ends at rest + Rbar(w) a. Gravity
turns with the nodes (Choi and Ko): its modal force is Phi^T (m exp([w])^T g), with w of the start of the step.

On a CPU core a step is bound by reading Phi and Psi from memory, once, for the free nodes; the iterations of the
sensors read the rows of a dozen nodes (docs/design/modal_warping.md).
"""

from functools import cached_property

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.modal_warping import modal_warping_kernels
from ..kernels.precision import Precision, precision
from ..model import Control, State
from ..model.modal_model import ModalModel
from .constraints import SensorConstraints
from .modal_newmark import TOLERANCE, ModalNewmark
from .protocol import StepReport
from .warped_sensors import WarpedSensors


class SolverModalWarping:
    """Advances mode_count decoupled modes; one unknown each.

    model: the modes. precision_name: of the node arrays; modal coordinates and sensors are always float64.
    tolerance: relative change that another iteration on the sensors would make.
    State.coordinates is q, (mode_count, 1, 1) float64 [m sqrt(kg)]: one component where reduced coordinates
    have three. State.coordinate_velocity is its rate.
    """

    name = "modal-warping"
    volume_mode = "none"
    contact_point_count = 0

    def __init__(self, model: ModalModel, precision_name: str = "float64", tolerance: float = TOLERANCE) -> None:
        self.model = model
        self.tongue = model.tongue
        self.report = StepReport()
        self._precision = precision(precision_name)
        self._nodes = _WarpedNodes(model, self._precision)
        self._newmark = ModalNewmark(model.eigenvalues, model.damping, WarpedSensors(model), tolerance)
        # In the sensors' own displacements the constraint rows select coordinates.
        self._constraints = SensorConstraints(model.tongue, np.eye(model.tongue.sensors.count))
        self._imposed: NDArray[np.intp] = np.zeros(0, dtype=np.intp)
        self._no_load = np.zeros(model.mode_count)

    @property
    def dof_count(self) -> int:
        return self.model.mode_count

    def new_state(self) -> State:
        vec3 = self._precision.vec3

        def zeros(shape: int | tuple[int, ...], dtype: type) -> wp.array:
            return wp.zeros(shape, dtype=dtype, device="cpu")

        return State(
            time=0.0,
            position=wp.array(self.tongue.mesh.nodes, dtype=vec3, device="cpu"),
            velocity=zeros(self.tongue.mesh.node_count, vec3),
            coordinates=zeros((self.model.mode_count, 1, 1), wp.float64),
            coordinate_velocity=zeros((self.model.mode_count, 1, 1), wp.float64),
            sensor_force=zeros(self.tongue.sensors.count, vec3),
        )

    def step(self, state_in: State, state_out: State, control: Control, dt: float) -> None:
        start = state_in.coordinates.numpy().reshape(-1)
        velocity = state_in.coordinate_velocity.numpy().reshape(-1)
        if self._constraints.set_control(control):
            self._imposed = self._constraints.rows.argmax(axis=1)
        load = self._nodes.gravity_load(start, control.gravity) if control.gravity.any() else self._no_load
        end, end_velocity, forces = self._newmark.advance(
            start, velocity, load, self._imposed, self._constraints.target, dt, self.report
        )
        state_out.coordinates.numpy()[:, 0, 0] = end
        state_out.coordinate_velocity.numpy()[:, 0, 0] = end_velocity
        self._fill_nodes(state_in, state_out, end, dt)
        state_out.sensor_force.numpy()[:] = self._constraints.forces(-forces)
        state_out.time = state_in.time + dt

    def _fill_nodes(self, state_in: State, state_out: State, coordinates: NDArray, dt: float) -> None:
        position, velocity = state_out.position.numpy(), state_out.velocity.numpy()
        position[:] = self._nodes.positions(coordinates)
        np.subtract(position, state_in.position.numpy(), out=velocity)
        velocity /= dt

    def strain_energy(self, state: State) -> float:
        """Strain energy [J] of the linear tongue behind a state (Yang 2013, Eq. 6)."""
        return self.model.strain_energy(state.coordinates.numpy())


class _WarpedNodes:
    """Positions of all nodes from modal coordinates; what it returns is overwritten by the next call.

    Only the free nodes are computed; the others stay where they are.
    """

    def __init__(self, model: ModalModel, p: Precision) -> None:
        tongue, self._free = model.tongue, model.tongue.free_nodes
        self._precision = p
        self._kernels = modal_warping_kernels(p.numpy.name)
        self._rows = model.warping_rows(self._free).reshape(-1, model.mode_count).astype(p.numpy)
        self._masses = tongue.node_masses[self._free]
        self._coordinates = np.zeros(model.mode_count, dtype=p.numpy)

        def array(dtype: type, values: NDArray) -> wp.array:
            return wp.array(values, dtype=dtype, device="cpu")

        self._linear = wp.zeros((2 * len(self._free), 3, 1), dtype=p.scalar, device="cpu")
        position = array(p.scalar, tongue.mesh.nodes[:, :, None])
        inputs: list[object] = [array(wp.int32, self._free), array(p.vec3, tongue.mesh.nodes), self._linear]
        self._warp = self._recorded(self._kernels.warp, inputs, position)
        # Zero-copy NumPy views of the Warp arrays.
        self._linear_values = self._linear.numpy().reshape(-1)
        self._position = position.numpy().reshape(-1, 3)

    def _recorded(self, kernel: wp.Kernel, inputs: list[object], output: wp.array) -> wp.Launch:
        """A launch over the free nodes whose arguments are packed once."""
        return wp.launch(kernel, (len(self._free), 1), inputs, [output], device="cpu", record_cmd=True)

    def _set_coordinates(self, coordinates: NDArray[np.float64]) -> None:
        """Fills linear displacements and rotation vectors: the product that reads all modes from memory."""
        self._coordinates[:] = coordinates
        np.dot(self._rows, self._coordinates, out=self._linear_values)

    def positions(self, coordinates: NDArray[np.float64]) -> NDArray[np.floating]:
        """Warped node positions [m], (node_count, 3)."""
        self._set_coordinates(coordinates)
        self._warp.launch()
        return self._position

    @cached_property
    def _gravity(self) -> tuple[wp.array, NDArray[np.floating], wp.Launch]:
        """Acceleration, load in the rows of the modes (6 free_count,), and the launch from one to the other."""
        p = self._precision
        acceleration = wp.zeros(1, dtype=p.vec3, device="cpu")
        masses: wp.array = wp.array(self._masses, dtype=p.scalar, device="cpu")
        load = wp.zeros_like(self._linear)
        launch = self._recorded(self._kernels.rotated_load, [masses, acceleration, self._linear], load)
        return acceleration, load.numpy().reshape(-1), launch

    def gravity_load(
        self, coordinates: NDArray[np.float64], gravity: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Modal force (mode_count,) of gravity [m/s^2] on the shape at `coordinates`."""
        acceleration, load, launch = self._gravity
        acceleration.numpy()[:] = gravity
        self._set_coordinates(coordinates)
        launch.launch()
        return (load @ self._rows).astype(np.float64)
