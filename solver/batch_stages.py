"""The stages of one step of a batch: calls bound to its arrays once, in the order in which they run."""

from collections.abc import Sequence

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.precision import precision
from ..kernels.quasi_newton import quasi_newton_kernels
from ..kernels.reduced_batch import reduced_batch_kernels
from ..model import Material, ReducedModel
from ..model.dense_product import DenseProduct, Stage, bind_product
from .batch_arrays import BatchArrays
from .batch_contact import BatchContact
from .lagged_inverse import LaggedInverse
from .newton import smallest_scale
from .parallel_stages import ParallelStages
from .volume_subspace import SubspaceVolume

LEAST_SCALE = {"float64": 1.0, "float32": 30.0}
"""Least force that a residual is compared with, in units of `smallest_scale`. A tongue that creeps back to rest has
viscous and elastic stresses that cancel to a thousandth, which float32 does not see."""
BLOCK = 128
"""Threads that share one tongue's vectors on CUDA."""


class BatchStages:
    """begin: before the first trial. evaluate: force at the trial, accepted or shortened. propose: the next trial.
    finish: the sensors to the last digit, state and nodes at the
    end of the step. elastic: force at the trial, contact as evaluated last.

    projected_inverse: Z, (n, n), and response: (n, c): what the caller keeps up to date.
    """

    def __init__(
        self,
        model: ReducedModel,
        arrays: BatchArrays,
        inverse: LaggedInverse,
        projected_inverse: wp.array,
        response: wp.array,
        materials: Sequence[Material],
        contact: BatchContact | None,
        step: float,
        tolerance: float,
        precision_name: str,
    ) -> None:
        self._model, self._arrays, self._materials = model, arrays, materials
        self._precision_name, self._scalar = precision_name, precision(precision_name).scalar
        self._tongue_count = arrays.state.shape[0]
        self._timed: list[wp.Launch] = []
        a, n, T = arrays, model.dof_count, self._tongue_count
        batch = reduced_batch_kernels(materials[0].model, precision_name)
        rows = model.gradient_operator
        if contact:
            rows = np.concatenate([rows, contact.rows])
        operator = self._product(rows)
        self._H = operator.head(len(model.gradient_operator))
        coordinates, velocity = a.by_degree(a.coordinates), a.by_degree(a.velocity)
        h = self._scalar(step)
        constrain = self._product(inverse.constraint_rows).bind(a.predicted, a.constrained)
        self.begin: list[Stage] = [
            *(contact.begin if contact else []),
            self._H.bind(a.coordinates, a.gradient_start),
            self._launch(batch.predict, (n, T), [coordinates, velocity, h], [a.predicted, a.trial]),
            constrain,
            self._launch(
                batch.begin,
                (n, T),
                [a.constrained, a.target, response],
                [a.trial, a.direction, a.accepted, a.length, a.state],
            ),
        ]
        gradient = self._H.bind(a.by_column(a.trial), a.gradient_increment)
        elements = self._elements(step)
        reduce_force = operator.transposed().bind(a.stacked, a.by_column(a.force))
        self.elastic: list[Stage] = [gradient, elements, reduce_force]
        beside = contact.evaluate if contact else []
        self.evaluate: list[Stage] = [
            ParallelStages([gradient, elements], beside, a.device),
            reduce_force,
            self._assess(velocity, inverse.constraint_basis, step, tolerance),
        ]
        self.propose: list[Stage] = [bind_product(projected_inverse, a.q, a.z), self._propose()]
        skin = self._product(np.hstack([model.basis, model.tongue.mesh.nodes])).bind(a.extended, a.position)
        advance = self._launch(batch.advance, (n, T), [a.accepted, h], [coordinates, velocity])
        end = [a.coordinates, a.by_column(a.accepted)], [a.by_column(a.predicted)]
        self._meet_targets: list[Stage] = [
            self._launch(batch.add, (model.column_count, 3, T), *end),
            constrain,
            self._launch(batch.meet, (n, T), [a.constrained, a.target, response], [a.accepted]),
            advance,
        ]
        self.finish: list[Stage] = [*self._meet_targets, skin, *(contact.finish if contact else [])]

    def correct_volume(self, volume: SubspaceVolume) -> None:
        """Corrects coordinates and rate before the skin follows; both corrections see where the step left them."""
        a = self._arrays
        skin, *others = self.finish[len(self._meet_targets) :]
        position = volume.bind_position(a.coordinates, a.gradient_start)
        velocity = volume.bind_velocity(a.velocity, a.coordinates, a.gradient_start)
        gradient = self._H.bind(a.coordinates, a.gradient_start)
        self.finish = [*self._meet_targets, gradient, *position, ParallelStages(velocity, [skin], a.device), *others]

    @property
    def gradient_operator(self) -> DenseProduct:
        """Products with H."""
        return self._H

    def set_time_step(self, step: float) -> None:
        """Changes the time step [s] in every launch that knows it."""
        for launch in self._timed:
            launch.set_param_by_name("step", self._scalar(step))
        self._assess_launch.set_param_by_name("smallest_scale", self._scalar(self._least_force(step)))
        self._damping_over_step.assign(np.array([m.damping_stiffness / step for m in self._materials]))

    def _product(self, A: NDArray[np.floating]) -> DenseProduct:
        return DenseProduct(A, self._precision_name, self._arrays.device)

    def _record(
        self, kernel: wp.Kernel, size: tuple[int, ...], inputs: list, outputs: list, block: int = 256
    ) -> wp.Launch:
        launch = wp.launch(
            kernel, size, inputs, outputs, device=self._arrays.device, record_cmd=True, block_dim=block
        )
        if any(argument.label == "step" for argument in kernel.adj.args):
            self._timed.append(launch)
        return launch

    def _launch(self, *arguments: object) -> Stage:
        stage: Stage = self._record(*arguments).launch  # type: ignore[arg-type]
        return stage

    def _elements(self, step: float) -> Stage:
        a, materials, types = self._arrays, self._materials, precision("float64")
        count = len(self._model.cubature_elements)
        weights = a.array(self._model.cubature_weights, types.scalar)
        elastic = a.array([m.elastic_parameters for m in materials], types.parameters)
        viscous = a.array([m.viscous_parameters for m in materials], types.parameters)
        self._damping_over_step = a.array([m.damping_stiffness / step for m in materials], types.scalar)
        inputs = [a.gradient_start, a.gradient_increment, weights, elastic, viscous, self._damping_over_step]
        kernel = reduced_batch_kernels(materials[0].model, self._precision_name).stress
        return self._launch(kernel, (count, self._tongue_count), inputs, [a.stacked[: 3 * count]])

    def _least_force(self, step: float) -> float:
        mass = float(self._model.tongue.node_masses.sum())
        return LEAST_SCALE[self._precision_name] * smallest_scale(mass, step)

    @property
    def _block(self) -> int:
        return 1 if wp.get_device(self._arrays.device).is_cpu else BLOCK

    def _assess(
        self, velocity: wp.array, constraint_basis: NDArray[np.floating], step: float, tolerance: float
    ) -> Stage:
        a, scalar = self._arrays, self._scalar
        filled = np.zeros((a.constraint_force.shape[0], self._model.dof_count))
        filled[: len(constraint_basis)] = constraint_basis
        damping = a.array([m.damping_mass for m in self._materials])
        limits = [scalar(self._least_force(step)), scalar(tolerance)]
        inputs = [a.force, velocity, a.load, a.array(filled), scalar(step), damping, *limits, a.trial, a.direction]
        outputs = [a.accepted, a.gradient, a.fresh, a.constraint_force, *a.pairs]
        outputs += [a.length, a.slope, a.error, a.state, a.q]
        kernel = quasi_newton_kernels(self._precision_name).assess
        self._assess_launch = self._record(kernel, (self._tongue_count, self._block), inputs, outputs, self._block)
        stage: Stage = self._assess_launch.launch
        return stage

    def _propose(self) -> Stage:
        a = self._arrays
        inputs = [a.z, a.accepted, a.gradient, *a.pairs, a.length, a.state]
        kernel = quasi_newton_kernels(self._precision_name).propose
        size = (self._tongue_count, self._block)
        return self._launch(kernel, size, inputs, [a.z, a.direction, a.slope, a.trial], self._block)
