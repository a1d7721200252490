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
        self._precision = p = precision(precision_name)
        self.device = device
        n, K, count = model.dof_count, model.column_count, len(model.cubature_elements)

        def zeros(*shape: int, dtype: object = None) -> wp.array:
            return wp.zeros(shape, dtype=dtype or p.scalar, device=device)

        def launch(kernel: wp.Kernel, size: object, inputs: list, outputs: list, block: int = 256) -> Stage:
            recorded = wp.launch(kernel, size, inputs, outputs, device=device, record_cmd=True, block_dim=block)
            return recorded.launch

        material = model.tongue.material
        reduced, kernels = reduced_kernels(precision_name), inverse_update_kernels(material.model, precision_name)
        block = 1 if wp.get_device(device).is_cpu else BLOCK
        self.inverse, self._safe, self._next = zeros(n, n), zeros(n, n), zeros(n, n)
        mean, gradient = zeros(K, 3), zeros(3 * count, 3)
        H = DenseProduct(model.gradient_operator, precision_name, device)
        operator: wp.array = wp.array(model.gradient_operator, dtype=p.scalar, device=device)
        weights: wp.array = wp.array(model.cubature_weights, dtype=wp.float64, device=device)
        parameters = precision("float64").parameters
        laws = [parameters(*material.elastic_parameters), parameters(*material.viscous_parameters)]
        damping = wp.float64(material.damping_stiffness / time_step)
        shift = p.scalar(1.0 / time_step**2 + material.damping_mass / time_step)
        tangent, products = zeros(count, 3, 3, dtype=p.mat33), zeros(3 * count, len(COMPONENT_PAIRS), K)
        blocks, hessian = zeros(K, len(COMPONENT_PAIRS), K), zeros(n, n)
        once, twice, candidate = zeros(n, n), zeros(n, n), zeros(n, n)
        image, growth = zeros(n, 1), zeros(1)
        vector: wp.array = wp.array(np.random.default_rng(0).standard_normal((n, 1)), dtype=p.scalar, device=device)
        power = [
            bind_product(once, vector, image),
            launch(kernels.normalise, block, [image], [vector, growth], block),
        ]
        basis = lagged.constraint_basis
        projector = DenseProduct(np.eye(n) - basis.T @ basis, precision_name, device)
        self.read: list[Stage] = [
            launch(kernels.mean, (K, 3, block), [coordinates], [mean], block),
            H.bind(mean, gradient),
        ]
        self.iterate: list[Stage] = [
            launch(kernels.tangent, (count, 9), [gradient, weights, *laws, damping], [tangent]),
            launch(reduced.tangent_times_gradient, (count, K), [operator, tangent], [products]),
            DenseProduct(model.gradient_operator.T, precision_name, device).bind(products, blocks),
            launch(kernels.assemble, (K, K), [blocks, shift], [hessian]),
            bind_product(hessian, self.inverse, once),
            bind_product(self.inverse, once, twice),
            *(POWER_ITERATIONS * power),
            launch(kernels.update, (n, n), [self.inverse, twice, growth, self._safe], [candidate]),
            projector.bind(candidate, self._next),
        ]

    def assign(self, inverse: NDArray[np.floating]) -> None:
        """Takes an inverse that was made on the host, to which a hopeless iteration returns."""
        self.inverse.assign(inverse)
        self._safe.assign(inverse)

    def accept(self) -> None:
        """Takes what `iterate` has made."""
        wp.copy(self.inverse, self._next)
