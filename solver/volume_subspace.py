"""Volume correction within the displacement and pressure subspaces (Luo 2017, section 8), for batches of tongues.

After a step, the reduced coordinates move by the dQ that minimises (the basis is mass-orthonormal)

    |dQ|^2 + rho l^2 |c(Q) + C dQ|^2   subject to   J dQ = 0,

c = P^T V (det F - 1) summed over the cubature elements, C its Jacobian, J the imposed sensor rows, l the compliance
length: the full-space correction with both unknowns restricted to their subspaces. Its solution dQ = -W c is linear
in c; W = N C^T (C N C^T + I / (rho l^2))^-1, N the projection on the null space of J, is kept from rest, or from
where `refresh` was last called. Then the whole volume, an exact polynomial of Q, is met by one Newton step along
Z dV/dQ, Z = N - W C N the inverse of what is minimised above: the direction in which it changes at least expense.
Rates are corrected in the same two ways.

The corrections are stages bound to arrays once, which neither allocate nor read back.
"""

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.precision import precision
from ..kernels.volume import volume_kernels
from ..model import ReducedModel
from ..model.dense_product import DenseProduct, Stage
from ..model.volume import SUBSPACE_COMPLIANCE_LENGTH
from ..model.volume_polynomial import TotalVolume
from ..model.volume_pressure import PressureSubspace, excess_jacobian
from .constraints import null_projector, row_space


class SubspaceVolume:
    """Corrects `tongue_count` tongues of one reduced model.

    constrained: (sensor_count, 3) bool, sensor coordinates that stay where they are, of all tongues alike.
    compliance_length: l [m]. gradient_operator: products with H that the caller has already.

    excess: det F - 1 of the cubature elements, or its rate, (cubature_count, tongue_count), before the correction.
    volume_change: what the whole volume lacked before the exact step of the last position correction, V - V0 [m^3],
    or dV/dt of the last velocity correction [m^3/s], (tongue_count,).
    """

    def __init__(
        self,
        model: ReducedModel,
        pressure: PressureSubspace,
        constrained: NDArray[np.bool_],
        tongue_count: int = 1,
        precision_name: str = "float64",
        device: str = "cpu",
        compliance_length: float = SUBSPACE_COMPLIANCE_LENGTH,
        gradient_operator: DenseProduct | None = None,
    ) -> None:
        self._model, self._pressure = model, pressure
        self._compliance = 1.0 / (model.tongue.material.density * compliance_length**2)
        self._tongue_count, self._device = tongue_count, device
        self._scalar = precision(precision_name).scalar
        self._kernels = volume_kernels(precision_name)
        self._null_space = _null_space(model, constrained)
        self._gradient_operator = gradient_operator or DenseProduct(model.gradient_operator, precision_name, device)
        self._rows = DenseProduct(pressure.cubature_rows, precision_name, device)
        response, inverse = self._operators_at(np.zeros((model.column_count, 3)))
        self._response = DenseProduct(response, precision_name, device)
        self._inverse = DenseProduct(inverse, precision_name, device)
        self._total = TotalVolume(pressure.volume_coefficients, tongue_count, precision_name, device)
        self.volume_change = self._total.change
        self.excess = self._zeros(len(model.cubature_elements), tongue_count)
        self._modes = self._zeros(pressure.mode_count, tongue_count)
        self._step = self._zeros(model.column_count, 3, tongue_count)

    def _zeros(self, *shape: int) -> wp.array:
        return wp.zeros(shape, dtype=self._scalar, device=self._device)

    def _operators_at(self, coordinates: NDArray[np.floating]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """-W (3 columns, modes) and Z (3 columns, 3 columns) with the Jacobian at coordinates (columns, 3)."""
        C = self._pressure.cubature_rows @ excess_jacobian(self._model.gradient_operator, coordinates)
        projected = C @ self._null_space
        gram = projected @ projected.T + self._compliance * np.eye(len(C))
        response = np.asarray(-np.linalg.solve(gram, projected).T, dtype=np.float64)
        inverse: NDArray[np.float64] = self._null_space + response @ projected
        return response, inverse

    def refresh(self, coordinates: NDArray[np.floating]) -> None:
        """Takes the Jacobian at coordinates (columns, 3), on the host; not for a captured frame."""
        response, inverse = self._operators_at(coordinates)
        self._response.update(response)
        self._inverse.update(inverse)

    def bind_gradient(self, values: wp.array) -> tuple[wp.array, Stage]:
        """An array for the stacked displacement gradients H values, (3 cubature_count, 3, tongues), and its stage."""
        gradient = self._zeros(3 * len(self._model.cubature_elements), 3, self._tongue_count)
        return gradient, self._gradient_operator.bind(values, gradient)

    def bind_position(self, coordinates: wp.array, gradient: wp.array | None = None) -> list[Stage]:
        """Stages that correct coordinates (columns, 3, tongue_count) in place.

        gradient: H times the coordinates when the caller keeps it up to date; it is not updated here.
        """
        stages: list[Stage] = []
        if gradient is None:
            gradient, product = self.bind_gradient(coordinates)
            stages.append(product)
        stages.append(self._over_elements(self._kernels.volume_excess, [gradient]))
        stages += self._mode_step(coordinates)
        stages += self._total_gradient(coordinates)
        return stages + self._total.bind_position_step(coordinates)

    def bind_velocity(
        self, velocity: wp.array, coordinates: wp.array, gradient: wp.array | None = None
    ) -> list[Stage]:
        """Stages that correct the coordinates' rate (columns, 3, tongue_count) in place, at the given coordinates.

        gradient: H times the coordinates when the caller keeps it up to date. One that lags by the last
        position correction makes no visible difference; the whole volume's rate is exact either way.
        """
        stages: list[Stage] = []
        if gradient is None:
            gradient, product = self.bind_gradient(coordinates)
            stages.append(product)
        rate, rate_product = self.bind_gradient(velocity)
        stages += [rate_product, self._over_elements(self._kernels.volume_rate, [gradient, rate])]
        stages += self._mode_step(velocity)
        stages += self._total_gradient(coordinates)
        return stages + self._total.bind_velocity_step(velocity)

    def _over_elements(self, kernel: wp.Kernel, inputs: list[object]) -> Stage:
        """A recorded launch that fills `excess`."""
        launch = wp.launch(
            kernel, self.excess.shape, inputs, [self.excess], device=self._device, record_cmd=True
        )
        stage: Stage = launch.launch
        return stage

    def _mode_step(self, values: wp.array) -> list[Stage]:
        """Adds -W c to the values, c from `excess`."""
        add = wp.launch(
            self._kernels.add, values.shape, [self._step], [values], device=self._device, record_cmd=True
        )
        return [
            self._rows.bind(self.excess, self._modes),
            self._response.bind(self._modes, self._by_degree(self._step)),
            add.launch,
        ]

    def _total_gradient(self, coordinates: wp.array) -> list[Stage]:
        """The whole volume's gradient, and the direction in which it is corrected."""
        direction = self._inverse.bind(
            self._by_degree(self._total.gradient), self._by_degree(self._total.direction)
        )
        return [*self._total.bind_gradient(coordinates), direction]

    def _by_degree(self, values: wp.array) -> wp.array:
        """(columns, 3, tongues) seen as (3 columns, tongues)."""
        return values.reshape((values.shape[0] * 3, self._tongue_count))


def _null_space(model: ReducedModel, constrained: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Orthogonal projection on the null space of the imposed sensor rows, (3 columns, 3 columns)."""
    rows = np.kron(model.sensor_rows, np.eye(3))[constrained.ravel()]
    return null_projector(row_space(rows)[0])
