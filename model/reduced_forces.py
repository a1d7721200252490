"""Elastic force and stiffness in the subspace, summed over weighted cubature elements (Luo 2017, Eq. 8-9)."""

from functools import cached_property

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.reduced import COMPONENT_PAIRS, reduced_kernels
from .discretisation import ElementForces
from .material import Material


class ReducedForces:
    """Evaluates H^T stress and H^T tangent H on the CPU: the material by Warp, the products by BLAS.

    gradient_operator: H, (3 * element_count, column_count). weights: cubature weights [m^3].
    Arrays returned are overwritten by the next call of the same method.
    """

    def __init__(
        self,
        material: Material,
        gradient_operator: NDArray[np.float64],
        weights: NDArray[np.float64],
        precision_name: str = "float64",
    ) -> None:
        self.elements = ElementForces(material, weights, precision_name, "cpu")
        p = self.elements.precision
        self._kernels = reduced_kernels(precision_name)
        rows, columns = gradient_operator.shape
        self.column_count = columns
        self.dtype = p.numpy
        self._operator: wp.array = wp.array(gradient_operator, dtype=p.scalar, device="cpu")
        # Zero-copy NumPy views of the Warp arrays.
        self._H = self._operator.numpy()
        self._H_transposed = np.ascontiguousarray(self._H.T)
        self._gradient = self.elements.gradient.numpy().reshape(rows, 3)
        self._stress = self.elements.stress.numpy().reshape(rows, 3)
        self._blocks = np.empty((columns, len(COMPONENT_PAIRS) * columns), dtype=p.numpy)
        self._stiffness = np.empty((columns, 3, columns, 3), dtype=p.numpy)

    @cached_property
    def _product(self) -> wp.array:
        shape = (3 * self.elements.count, len(COMPONENT_PAIRS), self.column_count)
        return wp.zeros(shape, dtype=self.elements.precision.scalar, device="cpu")

    def set_coordinates(self, coordinates: NDArray[np.floating]) -> None:
        """Evaluates the displacement gradients at reduced coordinates Q (column_count, 3)."""
        np.matmul(self._H, coordinates, out=self._gradient)

    def force(self, step: float | None = None) -> NDArray[np.floating]:
        """Reduced internal force (the energy's gradient), (column_count, 3), at the set coordinates."""
        self.elements.evaluate_stress(step)
        return self._H_transposed @ self._stress

    @cached_property
    def _direction(self) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
        """Views of the elements' direction and its stress, (3 * element_count, 3)."""
        direction, stress = self.elements.direction.numpy(), self.elements.direction_stress.numpy()
        return direction.reshape(-1, 3), stress.reshape(-1, 3)

    def apply_stiffness(self, direction: NDArray[np.floating]) -> NDArray[np.floating]:
        """Stiffness times a direction (column_count, 3), with the element tangents evaluated last."""
        gradient, stress = self._direction
        np.matmul(self._H, direction, out=gradient)
        self.elements.apply_tangent()
        return self._H_transposed @ stress

    def stiffness(self, step: float | None = None) -> NDArray[np.floating]:
        """Reduced stiffness at the set coordinates, (3 columns, 3 columns); index 3 k + i."""
        self.elements.evaluate_tangent(step)
        wp.launch(
            self._kernels.tangent_times_gradient,
            (self.elements.count, self.column_count),
            [self._operator, self.elements.tangent],
            [self._product],
            device="cpu",
        )
        tangent_H = self._product.numpy().reshape(3 * self.elements.count, -1)
        np.matmul(self._H_transposed, tangent_H, out=self._blocks)
        blocks = self._blocks.reshape(self.column_count, len(COMPONENT_PAIRS), self.column_count)
        for pair, (i, m) in enumerate(COMPONENT_PAIRS):
            self._stiffness[:, i, :, m] = blocks[:, pair]
            if i != m:
                self._stiffness[:, m, :, i] = blocks[:, pair].T
        size = 3 * self.column_count
        return self._stiffness.reshape(size, size)
