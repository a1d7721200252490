"""The whole tongue's volume as an exact cubic polynomial of the reduced coordinates, and its gradient.

The volume inside the closed boundary is sum_triangles det[x_0, x_1, x_2] / 6. With x = X + B Q = sum_a beta_a q_a,
where beta = [B, X] and q = [Q; e_1, e_2, e_3], Cauchy and Binet's formula gives, on the corners v of a triangle,

    V = sum_{a<b<c} t_abc det[q_a, q_b, q_c],
    t_abc = sum_triangles det[beta_a, beta_b, beta_c](v) / 6,

exactly and for any shape: with M_a = sum_{b<c} t_abc q_b x q_c the gradient with respect to q_a is M_a, and the
volume a third of sum_a q_a . M_a. The term t of the three unit vectors is the volume at rest; it is left out, so
what is evaluated is V - V0 without cancellation. One product of (columns + 3) x pairs numbers with the cross
products gives all of it, about 73,000 for 50 columns, where the element sum takes 10 million.
"""

from collections.abc import Sequence

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.precision import precision
from ..kernels.volume import volume_kernels
from .dense_product import DenseProduct, Stage
from .tet_mesh import TetMesh

TRIANGLES_AT_ONCE = 256
LANES = 32
"""Threads of a block that share one tongue's sums on CUDA."""


def column_pairs(count: int) -> NDArray[np.int32]:
    """The pairs b < c of `count` columns, (pair_count, 2)."""
    return np.stack(np.triu_indices(count, 1), axis=1).astype(np.int32)


def volume_coefficients(mesh: TetMesh, basis: NDArray[np.float64]) -> NDArray[np.float64]:
    """t_abc for a in the columns of [basis, X] and pairs b < c, (columns + 3, pair_count); V0's own term is zero.

    basis: (node_count, columns). X are the rest positions from the middle of the mesh [m].
    """
    middle = 0.5 * (mesh.nodes.min(axis=0) + mesh.nodes.max(axis=0))
    continued = np.hstack([basis, mesh.nodes - middle])
    first, second = column_pairs(continued.shape[1]).T
    coefficients = np.zeros((continued.shape[1], len(first)))
    triangles = mesh.boundary_triangles
    for begin in range(0, len(triangles), TRIANGLES_AT_ONCE):
        corners = continued[triangles[begin : begin + TRIANGLES_AT_ONCE]]
        for v in range(3):
            own, left, right = corners[:, v], corners[:, (v + 1) % 3], corners[:, (v + 2) % 3]
            minors = left[:, first] * right[:, second] - left[:, second] * right[:, first]
            coefficients += own.T @ minors
    coefficients /= 6.0
    rest = basis.shape[1]
    coefficients[rest:, (first >= rest) & (second >= rest)] = 0.0
    return coefficients


class TotalVolume:
    """Evaluates V - V0 and its gradient for `tongue_count` tongues, and moves values back along a direction.

    coefficients: of `volume_coefficients`.

    change: what was measured last for each tongue: V - V0 [m^3] or dV/dt [m^3/s], (tongue_count,).
    gradient: dV/dQ, (columns, 3, tongue_count), at the coordinates evaluated last.
    direction: (columns, 3, tongue_count), along which values are moved; the caller fills it.
    """

    def __init__(
        self,
        coefficients: NDArray[np.float64],
        tongue_count: int = 1,
        precision_name: str = "float64",
        device: str = "cpu",
    ) -> None:
        self._kernels = volume_kernels(precision_name)
        self._scalar = precision(precision_name).scalar
        self._device, self._tongue_count = device, tongue_count
        self._lanes = 1 if wp.get_device(device).is_cpu else LANES
        rows, pair_count = coefficients.shape
        self.columns = rows - 3
        self._pairs: wp.array = wp.array(column_pairs(rows), dtype=wp.int32, device=device)
        self._cross = self._zeros(pair_count, 3, tongue_count)
        self._gradient = self._zeros(rows, 3, tongue_count)
        self._step = self._zeros(tongue_count)
        self.change = self._zeros(tongue_count)
        self.gradient = self._gradient[: self.columns]
        self.direction = self._zeros(self.columns, 3, tongue_count)
        self._product = DenseProduct(coefficients, precision_name, device).bind(self._cross, self._gradient)

    def _zeros(self, *shape: int) -> wp.array:
        return wp.zeros(shape, dtype=self._scalar, device=self._device)

    def _recorded(self, kernel: wp.Kernel, size: Sequence[int], inputs: list[object], outputs: list[wp.array]) -> Stage:
        launch = wp.launch(kernel, size, inputs, outputs, device=self._device, record_cmd=True)
        stage: Stage = launch.launch
        return stage

    def bind_gradient(self, coordinates: wp.array) -> list[Stage]:
        """Stages that fill `gradient` at coordinates (columns, 3, tongue_count)."""
        size = (self._pairs.shape[0], self._tongue_count)
        cross = self._recorded(self._kernels.cross_products, size, [coordinates, self._pairs], [self._cross])
        return [cross, self._product]

    def bind_position_step(self, coordinates: wp.array) -> list[Stage]:
        """Stages that measure V - V0 and move the coordinates along `direction` until it vanishes, to first order.

        They take the gradient evaluated last, at the same coordinates.
        """
        return self._bind_step(coordinates, 1.0 / 3.0, self.columns + 3)

    def bind_velocity_step(self, velocity: wp.array) -> list[Stage]:
        """Stages that measure dV/dt and move the velocity along `direction` until it vanishes."""
        return self._bind_step(velocity, 1.0, self.columns)

    def _bind_step(self, values: wp.array, scale: float, row_count: int) -> list[Stage]:
        measure = wp.launch(
            self._kernels.volume_step,
            (self._tongue_count, self._lanes),
            [values, self._gradient, self.direction, self._scalar(scale), row_count, self._lanes],
            [self.change, self._step],
            device=self._device,
            block_dim=self._lanes,
            record_cmd=True,
        )
        size = (self.columns, 3, self._tongue_count)
        move = self._recorded(self._kernels.retreat, size, [self._step, self.direction], [values])
        return [measure.launch, move]
