"""Contact in the reduced space: springs at the collision points, seen through their rows of the basis."""

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.reduced import COMPONENT_PAIRS
from ..kernels.reduced_batch import reduced_batch_kernels
from ..model import ReducedModel
from ..model.contact_forces import ContactForces
from ..model.contact_scene import ContactScene
from ..model.dense_product import DenseProduct, Stage
from .batch_arrays import BatchArrays


class BatchContact:
    """Contact forces of a batch of tongues on its device, written to the last rows of `arrays.stacked`.

    rows: the basis at the collision points, (point_count, columns). time_step [s] may be changed.
    """

    def __init__(
        self, model: ReducedModel, scene: ContactScene, arrays: BatchArrays, precision_name: str, time_step: float
    ) -> None:
        self.time_step = time_step
        self.rows = model.basis[scene.points.nodes]
        coordinates, trial, device = arrays.coordinates, arrays.by_column(arrays.trial), arrays.device
        self.forces = ContactForces(
            model.tongue.mesh.nodes[scene.points.nodes],
            scene.points.areas,
            scene.grids,
            tongue_count=coordinates.shape[2],
            precision_name=precision_name,
            device=device,
            force=arrays.stacked[3 * len(model.cubature_elements) :],
        )
        candidate = wp.zeros(coordinates.shape, dtype=coordinates.dtype, device=device)
        rows = DenseProduct(self.rows, precision_name, device)
        add = wp.launch(
            reduced_batch_kernels(model.tongue.material.model, precision_name).add,
            coordinates.shape,
            [coordinates, trial],
            [candidate],
            device=device,
            record_cmd=True,
        ).launch
        self.begin: list[Stage] = [rows.bind(coordinates, self.forces.displacement_start), self.forces.begin_step]
        self.evaluate: list[Stage] = [add, rows.bind(candidate, self.forces.displacement), self._evaluate]
        self.finish: list[Stage] = [lambda: self.forces.poses_start.copy_from(self.forces.poses)]

    def _evaluate(self) -> None:
        self.forces.evaluate(self.time_step)

    def stiffness(self, tongues: NDArray[np.integer]) -> NDArray[np.floating]:
        """Mean over some tongues of the reduced stiffness (n, n) at the points evaluated last."""
        blocks = self.forces.stiffness.numpy()[:, :, tongues].mean(axis=2)
        columns = self.rows.shape[1]
        result = np.zeros((columns, 3, columns, 3))
        for (i, m), values in zip(COMPONENT_PAIRS, blocks.T, strict=True):
            touched = np.flatnonzero(values)
            block = self.rows[touched].T @ (values[touched, None] * self.rows[touched])
            result[:, i, :, m] = block
            result[:, m, :, i] = block
        return result.reshape(3 * columns, 3 * columns)

