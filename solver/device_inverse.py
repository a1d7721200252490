"""The projected inverse Hessian of a batch, kept up to date on its device without a factorisation.

At every call the tangent at the mean of the tongues is assembled by dense products and one Newton-Schulz iteration
(kernels/inverse_update.py) is taken. Nothing is read back, so the whole is part of a captured step.
"""

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.inverse_update import inverse_update_kernels
from ..kernels.precision import precision
from ..kernels.reduced import COMPONENT_PAIRS, reduced_kernels
from ..model import ReducedModel
from ..model.dense_product import DenseProduct, Stage, bind_product
from .constraints import null_projector
from .lagged_inverse import LaggedInverse

BLOCK = 64
POWER_ITERATIONS = 2
"""An update. The vector is kept from one to the next, so that these are enough."""


class DeviceInverse:
    """Z, (n, n), on `device`. coordinates: (columns, 3, tongue_count), those of the batch at the step's start.

    Three parts: `read` looks at the coordinates, `iterate` makes the next inverse and may run beside the step that
    uses the present one, `accept` takes it.
    """

    def __init__(
        self,
        model: ReducedModel,
        lagged: LaggedInverse,
        coordinates: wp.array,
        time_step: float,
        precision_name: str,
        device: str,
    ) -> None:
        self._scalar = precision(precision_name).scalar
        self._device, self._material = device, model.tongue.material
        n, K, count = model.dof_count, model.column_count, len(model.cubature_elements)
        kernels = inverse_update_kernels(self._material.model, precision_name)
        self._block = 1 if wp.get_device(device).is_cpu else BLOCK
        self.inverse, self._safe, self._next = (self._zeros(n, n) for _ in range(3))
        mean, gradient = self._zeros(K, 3), self._zeros(3 * count, 3)
        hessian, once, twice, candidate = (self._zeros(n, n) for _ in range(4))
        growth = self._zeros(1)
        projector = DenseProduct(null_projector(lagged.constraint_basis), precision_name, device)
        H = DenseProduct(model.gradient_operator, precision_name, device)
        self.read: list[Stage] = [
            self._launch(kernels.mean, (K, 3, self._block), [coordinates], [mean], self._block).launch,
            H.bind(mean, gradient),
        ]
        self.iterate: list[Stage] = [
            *self._assemble(model, H, gradient, hessian, time_step, precision_name),
            bind_product(hessian, self.inverse, once),
            bind_product(self.inverse, once, twice),
            *(POWER_ITERATIONS * self._power(once, growth, precision_name)),
            self._launch(kernels.update, (n, n), [self.inverse, twice, growth, self._safe], [candidate]).launch,
            projector.bind(candidate, self._next),
        ]

    def _zeros(self, *shape: int) -> wp.array:
        return wp.zeros(shape, dtype=self._scalar, device=self._device)

    def _launch(
        self, kernel: wp.Kernel, size: tuple[int, ...], inputs: list, outputs: list, block: int = 256
    ) -> wp.Launch:
        return wp.launch(kernel, size, inputs, outputs, device=self._device, record_cmd=True, block_dim=block)

    def _assemble(
        self,
        model: ReducedModel,
        H: DenseProduct,
        gradient: wp.array,
        hessian: wp.array,
        time_step: float,
        precision_name: str,
    ) -> list[Stage]:
        """The Hessian of a step that begins with the gradients given."""
        K, count, device = model.column_count, len(model.cubature_elements), self._device
        kernels = inverse_update_kernels(self._material.model, precision_name)
        operator: wp.array = wp.array(model.gradient_operator, dtype=self._scalar, device=device)
        weights: wp.array = wp.array(model.cubature_weights, dtype=wp.float64, device=device)
        tangent = wp.zeros((count, 3, 3), dtype=precision(precision_name).mat33, device=device)
        pairs = len(COMPONENT_PAIRS)
        products, blocks = self._zeros(3 * count, pairs, K), self._zeros(K, pairs, K)
        parameters = precision("float64").parameters
        laws = [parameters(*self._material.elastic_parameters), parameters(*self._material.viscous_parameters)]
        damping, shift = self._damping_and_shift(time_step)
        self._tangent = self._launch(kernels.tangent, (count, 9), [gradient, weights, *laws, damping], [tangent])
        self._inertia = self._launch(kernels.assemble, (K, K), [blocks, shift], [hessian])
        times_gradient = reduced_kernels(precision_name).tangent_times_gradient
        return [
            self._tangent.launch,
            self._launch(times_gradient, (count, K), [operator, tangent], [products]).launch,
            H.transposed().bind(products, blocks),
            self._inertia.launch,
        ]

    def _power(self, matrix: wp.array, growth: wp.array, precision_name: str) -> list[Stage]:
        """One power iteration with the matrix; its vector is kept."""
        n = matrix.shape[0]
        start = np.random.default_rng(0).standard_normal((n, 1))
        vector: wp.array = wp.array(start, dtype=self._scalar, device=self._device)
        image = self._zeros(n, 1)
        normalise = inverse_update_kernels(self._material.model, precision_name).normalise
        return [
            bind_product(matrix, vector, image),
            self._launch(normalise, (self._block,), [image], [vector, growth], self._block).launch,
        ]

    def _damping_and_shift(self, step: float) -> tuple[object, object]:
        material = self._material
        shift = 1.0 / step**2 + material.damping_mass / step
        return wp.float64(material.damping_stiffness / step), self._scalar(shift)

    def set_time_step(self, step: float) -> None:
        """Changes the time step [s] of the Hessian that is followed."""
        damping, shift = self._damping_and_shift(step)
        self._tangent.set_param_by_name("damping_over_step", damping)
        self._inertia.set_param_by_name("shift", shift)

    def assign(self, inverse: NDArray[np.floating]) -> None:
        """Takes an inverse that was made on the host, to which a hopeless iteration returns."""
        self.inverse.assign(inverse)
        self._safe.assign(inverse)

    def accept(self) -> None:
        """Takes what `iterate` has made."""
        wp.copy(self.inverse, self._next)
