"""Precisions the kernels are tested in, and NumPy in, NumPy out around the elasticity kernels."""

import numpy as np
import pytest
import warp as wp

from lingual.kernels.elasticity import elasticity_kernels
from lingual.kernels.precision import precision
from lingual.model import Material


@pytest.fixture(scope="session", params=["float64", "float32"])
def types(request):
    """The Warp types of one precision."""
    return precision(request.param)


@pytest.fixture(scope="session")
def close(types):
    """Function that asserts two arrays equal up to the precision's rounding, relative to the larger one's norm."""
    tolerance = 1e-12 if types.numpy == np.float64 else 3e-6

    def check(actual: np.ndarray, expected: np.ndarray) -> None:
        assert actual.shape == expected.shape
        assert np.linalg.norm(actual - expected) <= tolerance * np.linalg.norm(expected)

    return check


@pytest.fixture(scope="session")
def launch(device):
    """Function that launches a kernel on NumPy inputs (with their Warp types) into one zeroed output."""

    def run(kernel, size, inputs: list, shape, dtype) -> np.ndarray:
        arrays = [wp.array(a, dtype=t, device=device) for a, t in inputs]
        out = wp.zeros(shape, dtype=dtype, device=device)
        wp.launch(kernel, size, arrays, [out], device=device)
        return out.numpy()

    return run


class Elasticity:
    """The elasticity kernels of one material on deformation gradients F, (n, 3, 3)[i, j] = dx_i/dX_j."""

    def __init__(self, types, device: str, model: str = "stvk", **constants) -> None:
        self.material = Material(model, **constants)
        self.mu, self.lam = self.material.lame_mu, self.material.lame_lambda
        self.types, self.device = types, device
        self._kernels = elasticity_kernels(model, types.numpy.name)
        self._material = types.parameters(*self.material.elastic_parameters)
        self._viscosity = types.parameters(*self.material.viscous_parameters)

    def _gradient(self, F: np.ndarray) -> wp.array:
        transposed = (np.asarray(F) - np.eye(3)).transpose(0, 2, 1)
        return wp.array(transposed, dtype=self.types.mat33, device=self.device)

    def _loaded(self, F, F0, weight, damping_over_step) -> list:
        weight = np.ones(len(F)) if weight is None else weight
        return [
            self._gradient(F),
            self._gradient(np.tile(np.eye(3), (len(F), 1, 1)) if F0 is None else F0),
            wp.array(weight, dtype=self.types.scalar, device=self.device),
            self._material,
            self._viscosity,
            self.types.scalar(damping_over_step),
        ]

    def energy(self, F: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Energy density and det F, (n,) each."""
        density, det = (wp.zeros(len(F), dtype=self.types.scalar, device=self.device) for _ in range(2))
        inputs = [self._gradient(F), self._material]
        wp.launch(self._kernels.energy, len(F), inputs, [density, det], device=self.device)
        return density.numpy(), det.numpy()

    def stress(self, F, F0=None, weight=None, damping_over_step=0.0) -> np.ndarray:
        """Weighted first Piola stress, (n, 3, 3)[i, j]."""
        out = wp.zeros(len(F), dtype=self.types.mat33, device=self.device)
        inputs = self._loaded(F, F0, weight, damping_over_step)
        wp.launch(self._kernels.stress, len(F), inputs, [out], device=self.device)
        return out.numpy().transpose(0, 2, 1)

    def tangent(self, F, F0=None, weight=None, damping_over_step=0.0, definite=False) -> np.ndarray:
        """Weighted dP_ij / dF_mn, (n, 3, 3, 3, 3)[i, j, m, n], its elastic part projected when `definite`."""
        out = wp.zeros((len(F), 3, 3), dtype=self.types.mat33, device=self.device)
        inputs = self._loaded(F, F0, weight, damping_over_step)
        kernel = self._kernels.definite_tangent if definite else self._kernels.tangent
        wp.launch(kernel, len(F), inputs, [out], device=self.device)
        return out.numpy().transpose(0, 1, 3, 2, 4)

    def tangent_product(self, tangent: np.ndarray, dF: np.ndarray) -> np.ndarray:
        """tangent : dF, (n, 3, 3)."""
        stored = wp.array(tangent.transpose(0, 1, 3, 2, 4), dtype=self.types.mat33, device=self.device)
        direction = wp.array(dF.transpose(0, 2, 1), dtype=self.types.mat33, device=self.device)
        out = wp.zeros(len(dF), dtype=self.types.mat33, device=self.device)
        wp.launch(self._kernels.tangent_product, len(dF), [stored, direction], [out], device=self.device)
        return out.numpy().transpose(0, 2, 1)


@pytest.fixture(scope="session")
def elasticity_of(device):
    """Function (types, model, constants by name) -> Elasticity of that law."""
    return lambda types, model, **constants: Elasticity(types, device, model, **constants)


@pytest.fixture(scope="session")
def elasticity(types, device) -> Elasticity:
    """In both precisions, for comparison with an oracle."""
    return Elasticity(types, device)


@pytest.fixture(scope="session")
def exact_elasticity(device) -> Elasticity:
    """In double precision, for finite differences and invariances."""
    return Elasticity(precision("float64"), device)
