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
from dataclasses import replace

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.quasi_newton import CONVERGED
from ..model import LingualError, Material, ReducedModel, RigidPose
from ..model.contact_scene import ContactScene
from ..model.dense_product import Stage
from ..model.volume_pressure import PressureSubspace
from .batch_arrays import BatchArrays
from .batch_contact import BatchContact
from .batch_stages import BatchStages
from .device_inverse import DeviceInverse
from .lagged_inverse import LaggedInverse
from .volume_subspace import SubspaceVolume

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
CAPTURED_EVALUATIONS = 8


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
        self.captured_evaluations = captured_evaluations
        self.evaluations = 0
        self._tolerance, self._precision_name = tolerance, precision_name
        self._graph: wp.Graph | None = None
        self.materials = tuple(materials or [model.tongue.material] * tongue_count)
        if len(self.materials) != tongue_count or len({m.model for m in self.materials}) != 1:
            raise LingualError("A batch needs one material for each tongue, all of the same law.")
        typical = replace(model, tongue=replace(model.tongue, material=_typical(self.materials)))
        self._inverse = LaggedInverse(typical, constrained, precision_name)
        scene = contact if contact is not None and len(contact.points.nodes) else None
        points = len(scene.points.nodes) if scene else 0
        constraints = len(self._inverse.constraint_rows)
        self._arrays = a = BatchArrays(model, constraints, points, tongue_count, precision_name, device)
        self.coordinates, self.velocity, self.position, self.target = a.coordinates, a.velocity, a.position, a.target
        self._target_inbox = a.inbox(a.target)
        self._contact: BatchContact | None = None
        if scene:
            self._contact = BatchContact(model, scene, a, precision_name, step)
            poses = self._contact.forces.poses
            self._pose_inbox = a.inbox(poses.rotation), a.inbox(poses.translation)
        self._device_inverse: DeviceInverse | None = None
        self._projected_inverse, self._response = a.zeros(*[model.dof_count] * 2), a.zeros(model.dof_count, constraints)
        self._on_host = bool(wp.get_device(device).is_cpu)
        if not self._on_host:
            self._device_inverse = DeviceInverse(typical, self._inverse, a.coordinates, step, precision_name, device)
            self._projected_inverse = self._device_inverse.inverse
        self._stages = BatchStages(
            model, a, self._inverse, self._projected_inverse, self._response, self.materials, self._contact,
            step, tolerance, precision_name,
        )  # fmt: skip
        if pressure is not None:
            operator = self._stages.gradient_operator
            volume = SubspaceVolume(
                model, pressure, constrained, tongue_count, precision_name, device, gradient_operator=operator
            )
            self._stages.correct_volume(volume)
        self._unit_load = model.basis.T @ model.tongue.node_masses
        self._gravity: NDArray[np.float64] = np.zeros((3, tongue_count))
        self._state_view = a.state.numpy()
        self._renew()

    def set_time_step(self, step: float) -> None:
        """Changes the time step [s]; the inverse Hessian is renewed when it differs by more than one in a hundred."""
        if step == self.time_step:
            return
        changed = abs(step - self.time_step) > SAME_STEP * self.time_step
        self.time_step = step
        self._graph = None
        self._stages.set_time_step(step)
        if self._contact:
            self._contact.time_step = step
        if self._device_inverse:
            self._device_inverse.set_time_step(step)
        if changed:
            self._renew()

    def set_gravity(self, gravity: NDArray[np.float64]) -> None:
        """Takes gravity [m/s^2] in the jaw frame, (3,) or (3, tongue_count)."""
        wanted = np.broadcast_to(np.reshape(gravity, (3, -1)), (3, self.tongue_count))
        if not np.array_equal(wanted, self._gravity):
            self._gravity = wanted.copy()
            load = self._unit_load[:, None, None] * wanted
            self._arrays.load.assign(load.reshape(self.model.dof_count, -1))

    def set_jaw_poses(self, poses: RigidPose | Sequence[RigidPose]) -> None:
        """Takes the jaw's pose in the head at the end of the step, of all tongues or of each."""
        if self._contact:
            self._arrays.await_inboxes()
            each = [poses] * self.tongue_count if isinstance(poses, RigidPose) else list(poses)
            rotation, translation = self._pose_inbox
            rotation.numpy()[:] = np.array([pose.rotation for pose in each])
            translation.numpy()[:] = np.array([pose.translation for pose in each])

    def set_targets(self, displacement: NDArray[np.floating]) -> None:
        """Takes the displacement [m] that the imposed sensor coordinates have after the step.

        displacement: (constraint_count,) or (constraint_count, tongue_count).
        """
        self._arrays.await_inboxes()
        self._target_inbox.numpy()[:] = np.reshape(displacement, self.target.shape)

    @property
    def errors(self) -> NDArray[np.floating]:
        """Relative residual that each tongue reached in the last step, (tongue_count,)."""
        return self._arrays.error.numpy()

    @property
    def converged(self) -> NDArray[np.bool_]:
        """Which tongues met the tolerance and their targets in the last step, (tongue_count,)."""
        met: NDArray[np.bool_] = self.missed_targets < SMALLEST_MISS[self._precision_name]
        return (self._arrays.state.numpy() == CONVERGED) & met

    @property
    def missed_targets(self) -> NDArray[np.floating]:
        """Farthest that an imposed sensor coordinate is from its target [m], (tongue_count,)."""
        coordinates = self.coordinates.numpy().reshape(self.model.dof_count, -1)
        missed: NDArray[np.floating] = np.abs(self._inverse.constraint_rows @ coordinates - self.target.numpy())
        return missed.max(axis=0, initial=0.0)

    def constraint_forces(self) -> NDArray[np.floating]:
        """Force [N] with which each imposed sensor coordinate pulls, (constraint_count, tongue_count)."""
        carried = self._arrays.constraint_force.numpy()[: len(self._inverse.constraint_basis)]
        return self._inverse.multipliers(carried)

    def step(self) -> None:
        """Advances every tongue by one time step towards `target`."""
        if self._on_host:
            _run(self._stages.begin)
            self._minimise()
            _run(self._stages.finish)
        else:
            if self._graph is None:
                self._graph = self._capture()
            wp.capture_launch(self._graph)

    def _capture(self) -> wp.Graph:
        """One step of a fixed number of evaluations as a CUDA graph; the next inverse is made beside it."""
        assert self._device_inverse is not None
        beside = wp.Stream(self.device)
        with wp.ScopedCapture(device=self.device) as capture:
            self._arrays.read_inboxes()
            _run(self._stages.begin)
            _run(self._device_inverse.read)
            with wp.ScopedStream(beside):
                _run(self._device_inverse.iterate)
                finished = beside.record_event()
            for _ in range(self.captured_evaluations - 1):
                _run(self._stages.evaluate)
                _run(self._stages.propose)
            _run(self._stages.evaluate)
            _run(self._stages.finish)
            wp.get_stream(self.device).wait_event(finished)
            self._device_inverse.accept()
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
                _run(self._stages.evaluate)
                self.evaluations += 1
                if evaluation % ROUNDING_EVALUATIONS == 0:
                    self._accept_rounding()
                if (self._state_view == CONVERGED).all():
                    return
                _run(self._stages.propose)

    def _accept_rounding(self) -> None:
        """Takes as converged what is so relative to the elastic force at the step's start.

        A tongue that relaxes has elastic and viscous stresses that cancel; its residual cannot fall below what
        rounding leaves of them.
        """
        a = self._arrays
        kept = a.trial.numpy().copy()
        a.trial.zero_()
        _run(self._stages.elastic)
        elastic = np.linalg.norm(a.force.numpy(), axis=0)
        a.trial.assign(kept)
        residual, error = np.linalg.norm(a.gradient.numpy(), axis=0), a.error.numpy()
        searching = self._state_view != CONVERGED
        done = searching & np.isfinite(error) & (residual <= self._tolerance * elastic)
        self._state_view[done] = CONVERGED
        error[done] = residual[done] / np.maximum(elastic[done], 1e-30)

    def _renew(self, within_step: bool = False) -> None:
        """Makes the inverse Hessian anew, at the mean of the tongues or, within a step, at the one that lags most."""
        a = self._arrays
        tongues = np.arange(self.tongue_count)
        if within_step:
            tongues = np.argmax(np.where(a.state.numpy() == CONVERGED, 0.0, a.error.numpy()), keepdims=True)
        start = self.coordinates.numpy()[:, :, tongues]
        now = start
        if within_step:
            now = start + a.accepted.numpy()[:, tongues].reshape(start.shape)
        added = self._contact.stiffness(tongues) if self._contact else 0.0
        self._inverse.renew(start.mean(axis=2), now.mean(axis=2), self.time_step, added)
        (self._device_inverse or self._projected_inverse).assign(self._inverse.projected)
        self._response.assign(self._inverse.response)
        a.pair_count.zero_()


def _run(stages: Sequence[Stage]) -> None:
    for stage in stages:
        stage()


def _typical(materials: Sequence[Material]) -> Material:
    """The first material with the mean stiffness and damping of all."""
    return replace(
        materials[0],
        young_modulus=float(np.mean([m.young_modulus for m in materials])),
        damping_mass=float(np.mean([m.damping_mass for m in materials])),
        damping_stiffness=float(np.mean([m.damping_stiffness for m in materials])),
    )
