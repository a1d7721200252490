"""TongueBatch: one implicit step of any number of reduced tongues at once, on a CPU or captured on CUDA.

All tongues share one subspace and cubature; each has its own trajectory, jaw and material parameters. A step
is a sequence of stages, calls bound to arrays once, which allocate nothing and read nothing back. On a CPU the
host looks after each iteration whether all tongues have converged; on CUDA a fixed number of iterations is
captured in one graph, in which converged tongues stand still.

The unknown is the increment of the coordinates since the start of the step (kernels/reduced_batch.py), its
equations those of `newton`; the minimiser is `kernels.quasi_newton` with a projected inverse Hessian that is
renewed when iterations become many.
"""

from collections.abc import Sequence

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.precision import precision
from ..kernels.quasi_newton import quasi_newton_kernels
from ..kernels.reduced_batch import reduced_batch_kernels
from ..model import LingualError, Material, ReducedModel, RigidPose
from ..model.contact_scene import ContactScene
from ..model.dense_product import DenseProduct, Stage, bind_product
from ..model.volume_pressure import PressureSubspace
from .batch_contact import BatchContact, point_rows
from .device_inverse import DeviceInverse
from .lagged_inverse import LaggedInverse
from .newton import smallest_scale
from .parallel_stages import ParallelStages
from .volume_subspace import SubspaceVolume

PAIRS, CAPTURED_PAIRS = 16, 4
"""Curvature pairs that a tongue remembers, also from earlier steps; on CUDA each costs two waits in a block."""
GOOD_EVALUATIONS = 7
"""Evaluations of a step after which the inverse Hessian counts as aged."""
RENEWAL_EVALUATIONS = 16
"""Evaluations after which a step that has not converged renews it and goes on from where it is."""
RENEWALS = 4
ROUNDING_EVALUATIONS = 8
"""Evaluations after which a step looks whether only rounding is left (on the host)."""
SAME_STEP = 0.01
"""Relative change of the time step that an inverse Hessian does not notice: recorded times are rounded."""
SMALLEST_MISS = {"float64": 1e-6, "float32": 5e-6}
"""Distance [m] from its target at which a sensor counts as missed: targets that contradict each other."""
LEAST_SCALE = {"float64": 1.0, "float32": 30.0}
"""Least force that a residual is compared with, in units of `smallest_scale`. A tongue that creeps back to rest has
viscous and elastic stresses that cancel to a thousandth, which float32 does not see."""
CAPTURED_EVALUATIONS = 8
BLOCK = 128
"""Threads that share one tongue's vectors on CUDA."""
CONVERGED = 3


class TongueBatch:
    """`tongue_count` tongues of one reduced model.

    tolerance: relative residual at which a tongue stops. captured_evaluations: of every step on CUDA.
    materials: one per tongue, all of one law; the model's own by default. contact: the mouth around.
    pressure: subspace in which the volume is corrected after the step, None for no correction.
    step: time step [s]. constrained: (sensor_count, 3) bool, the sensor coordinates that are imposed, on all
    tongues alike.

    coordinates, velocity: (columns, 3, tongue_count) and their rate [1/s], on the device.
    target: displacement imposed on the constrained sensor coordinates [m], (constraint_count, tongue_count).
    position: node positions [m], (node_count, 3, tongue_count), jaw frame, filled by `step`.
    """

    def __init__(
        self,
        model: ReducedModel,
        constrained: NDArray[np.bool_],
        step: float = 0.01,
        tongue_count: int = 1,
        precision_name: str = "float64",
        device: str = "cpu",
        tolerance: float = 1e-8,
        materials: Sequence[Material] | None = None,
        captured_evaluations: int = CAPTURED_EVALUATIONS,
        contact: ContactScene | None = None,
        pressure: PressureSubspace | None = None,
    ) -> None:
        self.model = model
        self.tongue_count = tongue_count
        self.device = device
        self.time_step = step
        self._tolerance = tolerance
        self.captured_evaluations = captured_evaluations
        self._on_host = wp.get_device(device).is_cpu
        self._graph: wp.Graph | None = None
        self._timed: list[wp.Launch] = []
        self._precision = precision(precision_name)
        self._precision_name = precision_name
        self.materials = tuple(materials or [model.tongue.material] * tongue_count)
        if len(self.materials) != tongue_count or len({m.model for m in self.materials}) != 1:
            raise LingualError("A batch needs one material for each tongue, all of the same law.")
        self._pressure, self._imposed = pressure, constrained
        self._scene = contact if contact is not None and len(contact.points.nodes) else None
        self._inverse = LaggedInverse(model, constrained, precision_name)
        self._unit_load = model.basis.T @ model.tongue.node_masses
        self._allocate()
        self._bind(step, tolerance)
        self.evaluations = 0
        self._renew()

    def set_time_step(self, step: float) -> None:
        """Changes the time step [s]; the inverse Hessian is renewed when it differs by more than one in a hundred."""
        if step == self.time_step:
            return
        scalar = self._precision.scalar
        for launch in self._timed:
            launch.set_param_by_name("step", scalar(step))
        self._damping_over_step.assign(np.array([m.damping_stiffness / step for m in self.materials]))
        changed = abs(step - self.time_step) > SAME_STEP * self.time_step
        self.time_step = step
        if self.contact:
            self.contact.time_step = step
        self._graph = None
        if changed:
            self._renew()

    def set_gravity(self, gravity: NDArray[np.float64]) -> None:
        """Takes gravity [m/s^2] in the jaw frame, (3,) or (3, tongue_count)."""
        wanted = np.broadcast_to(np.reshape(gravity, (3, -1)), (3, self.tongue_count))
        if not np.array_equal(wanted, self._gravity):
            self._gravity = wanted.copy()
            load = self._unit_load[:, None, None] * wanted
            self._vector["load"].assign(load.reshape(self.model.dof_count, -1))

    def set_jaw_poses(self, poses: RigidPose | Sequence[RigidPose]) -> None:
        """Takes the jaw's pose in the head at the end of the step, of all tongues or of each."""
        if self.contact:
            self._await_inboxes()
            each = [poses] * self.tongue_count if isinstance(poses, RigidPose) else list(poses)
            rotation, translation = self._pose_inbox
            rotation.numpy()[:] = np.array([pose.rotation for pose in each])
            translation.numpy()[:] = np.array([pose.translation for pose in each])

    def _await_inboxes(self) -> None:
        """The host's inboxes may be written once the step that reads them is over."""
        if not self._on_host:
            wp.synchronize_stream(wp.get_stream(self.device))

    def _inbox(self, array: wp.array) -> wp.array:
        """Memory of the host that a step reads by itself: on a CPU the array, on CUDA a pinned copy of it."""
        if self._on_host:
            return array
        inbox = wp.zeros(array.shape, dtype=array.dtype, device="cpu", pinned=True)
        self._inboxes.append((array, inbox))
        return inbox

    def set_targets(self, displacement: NDArray[np.float64]) -> None:
        """Takes the displacement [m] that the imposed sensor coordinates have after the step.

        displacement: (constraint_count,) or (constraint_count, tongue_count).
        """
        self._await_inboxes()
        self._target_inbox.numpy()[:] = np.reshape(displacement, self.target.shape)

    @property
    def errors(self) -> NDArray[np.floating]:
        """Relative residual that each tongue reached in the last step, (tongue_count,)."""
        return self._error.numpy()

    @property
    def converged(self) -> NDArray[np.bool_]:
        """Which tongues met the tolerance and their targets in the last step, (tongue_count,)."""
        return (self._state.numpy() == CONVERGED) & (self.missed_targets < SMALLEST_MISS[self._precision_name])

    @property
    def missed_targets(self) -> NDArray[np.floating]:
        """Farthest that an imposed sensor coordinate is from its target [m], (tongue_count,)."""
        coordinates = self.coordinates.numpy().reshape(self.model.dof_count, -1)
        return np.abs(self._inverse.constraint_rows @ coordinates - self.target.numpy()).max(axis=0, initial=0.0)

    def constraint_forces(self) -> NDArray[np.floating]:
        """Force [N] with which each imposed sensor coordinate pulls, (constraint_count, tongue_count)."""
        return self._inverse.multipliers(self._constraint_force.numpy()[: len(self._inverse.constraint_basis)])

    def _zeros(self, *shape: int, dtype: object = None) -> wp.array:
        return wp.zeros(shape, dtype=dtype or self._precision.scalar, device=self.device)

    def _allocate(self) -> None:
        model, T = self.model, self.tongue_count
        K, n = model.column_count, model.dof_count
        constraints, independent = len(self._inverse.constraint_rows), len(self._inverse.constraint_basis)
        fours = 4 * -(-independent // 4)
        # Three more rows, the identity, carry the rest shape through the skinning product.
        self._extended = self._zeros(K + 3, 3, T)
        host = np.zeros((K + 3, 3, T))
        host[K:] = np.eye(3)[:, :, None]
        self._extended.assign(host)
        self.coordinates = self._extended[:K]
        self.velocity = self._zeros(K, 3, T)
        self.target = self._zeros(constraints, T)
        self._inboxes: list[tuple[wp.array, wp.array]] = []
        self._target_inbox = self._inbox(self.target)
        self.position = self._zeros(model.tongue.mesh.node_count, 3, T)
        rows = 3 * len(model.cubature_elements)
        self._gradient_start, self._gradient_increment = self._zeros(rows, 3, T), self._zeros(rows, 3, T)
        points = len(self._scene.points.nodes) if self._scene else 0
        # Element stresses, then the forces at the collision points: one product reduces both.
        self._stacked = self._zeros(rows + points, 3, T)
        vectors = ["predicted", "trial", "direction", "accepted", "gradient", "fresh", "force", "load", "q", "z"]
        self._vector = {name: self._zeros(n, T) for name in vectors}
        pairs = PAIRS if self._on_host else CAPTURED_PAIRS
        self._pair_step, self._pair_change = self._zeros(pairs, n, T), self._zeros(pairs, n, T)
        self._pair_scale, self._pair_share = self._zeros(pairs, T), self._zeros(pairs, T)
        self._pair_count = self._zeros(T, dtype=wp.int32)
        self._state = self._zeros(T, dtype=wp.int32)
        self._state_view = self._state.numpy()
        self._gravity = np.zeros((3, T))
        self._length, self._slope, self._error = self._zeros(T), self._zeros(T), self._zeros(T)
        self._constrained, self._constraint_force = self._zeros(constraints, T), self._zeros(fours, T)

    def _launch(self, kernel: wp.Kernel, dim: object, inputs: list, outputs: list, block_dim: int = 256) -> Stage:
        """A recorded launch; `set_time_step` finds those that take the step."""
        launch = wp.launch(
            kernel, dim, inputs, outputs, device=self.device, record_cmd=True, block_dim=block_dim
        )
        if any(argument.label == "step" for argument in kernel.adj.args):
            self._timed.append(launch)
        return launch.launch

    def _bind(self, step: float, tolerance: float) -> None:
        p, v, model = self._precision, self._vector, self.model
        n, T = model.dof_count, self.tongue_count
        law = self.materials[0].model
        batch, search = reduced_batch_kernels(law, self._precision_name), quasi_newton_kernels(self._precision_name)
        product = self._product
        coordinates, velocity = (a.reshape((n, T)) for a in (self.coordinates, self.velocity))
        h, mass = p.scalar(step), float(model.tongue.node_masses.sum())
        scale = LEAST_SCALE[self._precision_name] * smallest_scale(mass, step)
        inverse = self._inverse
        filled = np.zeros((self._constraint_force.shape[0], n))
        filled[: len(inverse.constraint_basis)] = inverse.constraint_basis
        self._basis_of_constraints = self._array(filled)
        self._response = self._array(np.zeros((n, len(inverse.constraint_rows))))
        self._on_device = None if self._on_host else DeviceInverse(
            model, inverse, self.coordinates, step, self._precision_name, self.device
        )
        self._projected_inverse = self._on_device.inverse if self._on_device else self._zeros(n, n)
        weights = self._array(model.cubature_weights, wp.float64)
        element_inputs = [self._gradient_start, self._gradient_increment, weights, *self._material_arrays(step)]
        element_count = len(model.cubature_elements)
        stress = self._stacked[: 3 * element_count]
        elements = self._launch(batch.stress, (element_count, T), element_inputs, [stress])
        trial, force = (v[name].reshape((model.column_count, 3, T)) for name in ("trial", "force"))
        rows = model.gradient_operator
        self.contact: BatchContact | None = None
        if self._scene:
            self.contact = BatchContact(
                model, self._scene, self.coordinates, trial, self._stacked[3 * element_count :], self._precision_name
            )
            self.contact.time_step = step
            poses = self.contact.forces.poses
            self._pose_inbox = self._inbox(poses.rotation), self._inbox(poses.translation)
            self._pose_inbox[0].numpy()[:] = np.eye(3)
            rows = np.concatenate([rows, point_rows(model, self._scene)])
        operator = product(rows)
        H = operator.head(3 * element_count)
        self._begin = [
            *(self.contact.begin if self.contact else []),
            H.bind(self.coordinates, self._gradient_start),
            self._launch(batch.predict, (n, T), [coordinates, velocity, h], [v["predicted"], v["trial"]]),
            product(inverse.constraint_rows).bind(v["predicted"], self._constrained),
            self._launch(
                batch.begin,
                (n, T),
                [self._constrained, self.target, self._response],
                [v["trial"], v["direction"], v["accepted"], self._length, self._state],
            ),
        ]
        pairs = [self._pair_step, self._pair_change, self._pair_scale, self._pair_share, self._pair_count]
        limits, at = [p.scalar(scale), p.scalar(tolerance)], [v["trial"], v["direction"]]
        search_state = [self._length, self._slope, self._error, self._state]
        block = 1 if self._on_host else BLOCK
        damping = self._array([m.damping_mass for m in self.materials])
        reduce_force = operator.transposed().bind(self._stacked, force)
        gradient = H.bind(trial, self._gradient_increment)
        self._elastic = [gradient, elements, reduce_force]
        self._evaluate = [
            ParallelStages(
                [gradient, elements],
                self.contact.evaluate if self.contact else [],
                self.device,
            ),
            reduce_force,
            self._launch(
                search.assess,
                (T, block),
                [v["force"], velocity, v["load"], self._basis_of_constraints, h, damping, *limits, *at],
                [v["accepted"], v["gradient"], v["fresh"], self._constraint_force, *pairs, *search_state, v["q"]],
                block_dim=block,
            ),
        ]
        self._propose = [
            bind_product(self._projected_inverse, v["q"], v["z"]),
            self._launch(
                search.propose,
                (T, block),
                [v["z"], v["accepted"], v["gradient"], *pairs, self._length, self._state],
                [v["z"], v["direction"], self._slope, v["trial"]],
                block_dim=block,
            ),
        ]
        skin = product(np.hstack([model.basis, model.tongue.mesh.nodes]))
        self._finish = [
            self._launch(batch.advance, (n, T), [v["accepted"], h], [coordinates, velocity]),
            *self._volume_stages(H, [skin.bind(self._extended, self.position)]),
            *(self.contact.finish if self.contact else []),
        ]

    def _volume_stages(self, H: DenseProduct, skin: list[Stage]) -> list[Stage]:
        """Correction of coordinates, which the skin follows, and of their rate; both see where the step left them."""
        if self._pressure is None:
            return skin
        volume = SubspaceVolume(
            self.model,
            self._pressure,
            self._imposed,
            self.tongue_count,
            self._precision_name,
            self.device,
            gradient_operator=H,
        )
        gradient = self._gradient_start
        position = volume.bind_position(self.coordinates, gradient)
        velocity = volume.bind_velocity(self.velocity, self.coordinates, gradient)
        return [H.bind(self.coordinates, gradient), *position, ParallelStages(velocity, skin, self.device)]

    def _array(self, values: object, dtype: object = None) -> wp.array:
        return wp.array(values, dtype=dtype or self._precision.scalar, device=self.device)

    def _product(self, A: NDArray[np.floating]) -> DenseProduct:
        return DenseProduct(A, self._precision_name, self.device)

    def _material_arrays(self, step: float) -> list[wp.array]:
        elastic = [m.elastic_parameters for m in self.materials]
        viscous = [m.viscous_parameters for m in self.materials]
        damping = [m.damping_stiffness / step for m in self.materials]
        parameters = precision("float64").parameters
        self._damping_over_step = self._array(damping, wp.float64)
        return [self._array(elastic, parameters), self._array(viscous, parameters), self._damping_over_step]

    def step(self) -> None:
        """Advances every tongue by one time step towards `target`."""
        if self._on_host:
            self._run(self._begin)
            self._minimise()
            self._run(self._finish)
        else:
            if self._graph is None:
                self._graph = self._capture()
            wp.capture_launch(self._graph)

    @staticmethod
    def _run(stages: list[Stage]) -> None:
        for stage in stages:
            stage()

    def _capture(self) -> wp.Graph:
        """One step of a fixed number of evaluations as a CUDA graph; the next inverse is made beside it."""
        assert self._on_device is not None
        beside = wp.Stream(self.device)
        with wp.ScopedCapture(device=self.device) as capture:
            for array, inbox in self._inboxes:
                wp.copy(array, inbox)
            self._run(self._begin)
            self._run(self._on_device.read)
            with wp.ScopedStream(beside):
                self._run(self._on_device.iterate)
                finished = beside.record_event()
            for _ in range(self.captured_evaluations - 1):
                self._run(self._evaluate)
                self._run(self._propose)
            self._run(self._evaluate)
            self._run(self._finish)
            wp.get_stream(self.device).wait_event(finished)
            self._on_device.accept()
        self.evaluations = self.captured_evaluations
        return capture.graph

    def _minimise(self) -> None:
        if self.evaluations > GOOD_EVALUATIONS:
            self._renew()
        self.evaluations = 0
        for renewal in range(RENEWALS):
            if renewal:
                self._renew(within_step=True)
            for evaluation in range(1, RENEWAL_EVALUATIONS + 1):
                self._run(self._evaluate)
                self.evaluations += 1
                if evaluation % ROUNDING_EVALUATIONS == 0:
                    self._accept_rounding()
                if (self._state_view == CONVERGED).all():
                    return
                self._run(self._propose)

    def _accept_rounding(self) -> None:
        """Takes as converged what is so relative to the elastic force at the step's start.

        A tongue that relaxes has elastic and viscous stresses that cancel; its residual cannot fall below what
        rounding leaves of them.
        """
        trial, force = self._vector["trial"], self._vector["force"]
        kept = trial.numpy().copy()
        trial.zero_()
        self._run(self._elastic)
        elastic = np.linalg.norm(force.numpy(), axis=0)
        trial.assign(kept)
        residual = np.linalg.norm(self._vector["gradient"].numpy(), axis=0)
        searching = self._state_view != CONVERGED
        done = searching & (self._error.numpy() < np.inf) & (residual <= self._tolerance * elastic)
        self._state_view[done] = CONVERGED
        self._error.numpy()[done] = residual[done] / np.maximum(elastic[done], 1e-30)

    def _renew(self, within_step: bool = False) -> None:
        """Makes the inverse Hessian anew, at the mean of the tongues or, within a step, at the one that lags most."""
        start = self.coordinates.numpy()
        tongues = np.arange(self.tongue_count)
        if within_step:
            tongues = np.argmax(np.where(self._state.numpy() == CONVERGED, 0.0, self._error.numpy()), keepdims=True)
        start = start[:, :, tongues]
        now = start
        if within_step:
            now = start + self._vector["accepted"].numpy()[:, tongues].reshape(start.shape)
        added = self.contact.stiffness(tongues) if self.contact else 0.0
        self._inverse.renew(start.mean(axis=2), now.mean(axis=2), self.time_step, added)
        (self._on_device or self._projected_inverse).assign(self._inverse.projected)
        self._response.assign(self._inverse.response)
        self._pair_count.zero_()
