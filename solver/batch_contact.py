"""Contact in the reduced space: springs at the collision points, seen through their rows of the basis."""

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.reduced_batch import reduced_batch_kernels
from ..model import ReducedModel
from ..model.contact_forces import ContactForces
from ..model.contact_scene import ContactScene
from ..model.dense_product import DenseProduct, Stage

COMPONENTS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""Order in which ContactForces stores a point's stiffness."""


class BatchContact:
    """Contact forces of a batch of tongues on its device.

    coordinates, trial: (columns, 3, tongue_count), the state at the start of the step and the increment.
    force: rows of a stacked array that take the points' forces, (point_count, 3, tongue_count).
    """

    def __init__(
        self,
        model: ReducedModel,
        scene: ContactScene,
        coordinates: wp.array,
        trial: wp.array,
        force: wp.array,
        precision_name: str,
    ) -> None:
        self.tongue_count = coordinates.shape[2]
        self._rows = point_rows(model, scene)
        device = str(coordinates.device)
        self.forces = ContactForces(
            model.tongue.mesh.nodes[scene.points.nodes],
            scene.points.areas,
            scene.grids,
            tongue_count=self.tongue_count,
            precision_name=precision_name,
            device=device,
            force=force,
        )
        candidate = wp.zeros(coordinates.shape, dtype=coordinates.dtype, device=device)
        rows = DenseProduct(self._rows, precision_name, device)
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
        self.time_step = 0.0

    def _evaluate(self) -> None:
        self.forces.evaluate(self.time_step)

    def stiffness(self, tongues: NDArray[np.integer]) -> NDArray[np.floating]:
        """Mean over some tongues of the reduced stiffness (n, n) at the points evaluated last."""
        blocks = self.forces.stiffness.numpy()[:, :, tongues].mean(axis=2)
        columns = self._rows.shape[1]
        result = np.zeros((columns, 3, columns, 3))
        for (i, m), values in zip(COMPONENTS, blocks.T, strict=True):
            touched = np.flatnonzero(values)
            block = self._rows[touched].T @ (values[touched, None] * self._rows[touched])
            result[:, i, :, m] = block
            result[:, m, :, i] = block
        return result.reshape(3 * columns, 3 * columns)


def point_rows(model: ReducedModel, scene: ContactScene) -> NDArray[np.float64]:
    """The basis at the collision points, (point_count, columns)."""
    return model.basis[scene.points.nodes]
