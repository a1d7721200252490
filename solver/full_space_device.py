"""Full-space steps by Newton's method with conjugate gradients, on any device.

Elements, matrix and every vector of the linear solution live on the device; Newton's few vectors are the host's.
"""

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.full_space_cg import full_space_cg_kernels
from ..model import Control, TongueModel
from .device_cg import DeviceConjugateGradients
from .full_space_step import FullSpaceStep
from .nodal_terms import NodalTerm
from .projected_cg import SAME_STEP

AGED_ITERATIONS = 150
"""Conjugate gradients after which the coarse space's matrix is made again; making it costs some hundred."""


class DeviceStep(FullSpaceStep):
    """A step whose tangents stay on the device (a newton.StepProblem)."""

    def __init__(self, tongue: TongueModel, terms: tuple[NodalTerm, ...], device: str) -> None:
        super().__init__(tongue, terms, device)
        pattern = self._discretisation.pattern
        points = tongue.mesh.nodes[self._free]
        self._cg = DeviceConjugateGradients(points, pattern.row_starts, pattern.columns, device)
        self._factor_dt = 0.0
        self._diagonal_places: wp.array = wp.array(self._diagonal_blocks, dtype=wp.int32, device=device)

    def begin(self, start: NDArray, velocity: NDArray, control: Control, dt: float) -> None:
        super().begin(start, velocity, control, dt)
        if self._constraints_changed or abs(dt - self._factor_dt) > SAME_STEP * dt:
            self._cg.forget()
            self._factor_dt = dt

    def newton_step(self, x: NDArray, residual: NDArray, gap: NDArray) -> tuple[NDArray, NDArray]:
        try:
            return self._solve_linear(x, residual, gap, definite=False)
        except np.linalg.LinAlgError:
            return self._solve_linear(x, residual, gap, definite=True)

    def _solve_linear(self, x: NDArray, residual: NDArray, gap: NDArray, definite: bool) -> tuple[NDArray, NDArray]:
        self._discretisation.evaluate_stiffness(self._dt, definite)
        blocks = self._discretisation.blocks
        diagonal: wp.array = wp.array(self._tangent_diagonal(x), dtype=wp.mat33d, device=blocks.device)
        inputs = [diagonal, self._diagonal_places]
        wp.launch(full_space_cg_kernels().add_diagonal, len(diagonal), inputs, [blocks], device=blocks.device)
        self._cg.set_matrix(blocks)
        if not self._cg.ready or self._cg.iterations > AGED_ITERATIONS:
            self._cg.renew(self.constraints.rows)
        return self._cg.solve(-residual, gap)
