"""Kernels on reduced coordinates against NumPy."""

import numpy as np
import pytest

from lingual.kernels.reduced import COMPONENT_PAIRS, reduced_kernels

RNG = np.random.default_rng(3)
ELEMENTS, COLUMNS, PAIRS = 6, 5, len(COMPONENT_PAIRS)
H = RNG.standard_normal((3 * ELEMENTS, COLUMNS))
H_BY_ELEMENT = H.reshape(ELEMENTS, 3, COLUMNS)
TANGENT = RNG.standard_normal((ELEMENTS, 3, 3, 3, 3))  # [e, i, m, j, n]
I, M = np.array(COMPONENT_PAIRS).T


@pytest.fixture
def kernels(types):
    return reduced_kernels(types.numpy.name)


def test_gradient_is_the_operator_times_the_coordinates(kernels, types, launch, close):
    Q = RNG.standard_normal((COLUMNS, 3))
    gradient = launch(kernels.gradient, ELEMENTS, [(H, types.scalar), (Q, types.vec3)], ELEMENTS, types.mat33)
    close(gradient, (H @ Q).reshape(ELEMENTS, 3, 3))


def test_force_is_the_transposed_operator_times_the_stress(kernels, types, launch, close):
    stress = RNG.standard_normal((ELEMENTS, 3, 3))
    force = launch(kernels.force, COLUMNS, [(H, types.scalar), (stress, types.mat33)], COLUMNS, types.vec3)
    close(force, H.T @ stress.reshape(-1, 3))


def test_tangent_times_gradient_covers_the_six_component_pairs(kernels, types, launch, close):
    inputs = [(H, types.scalar), (TANGENT, types.mat33)]
    shape = (3 * ELEMENTS, PAIRS, COLUMNS)
    product = launch(kernels.tangent_times_gradient, (ELEMENTS, COLUMNS), inputs, shape, types.scalar)
    expected = np.einsum("epjn,enk->ejpk", TANGENT[:, I, M], H_BY_ELEMENT)
    close(product, expected.reshape(shape))


def test_stiffness_blocks_are_sums_over_all_rows(kernels, types, launch, close):
    product = RNG.standard_normal((3 * ELEMENTS, PAIRS, COLUMNS))
    inputs = [(H, types.scalar), (product, types.scalar)]
    shape = (COLUMNS, PAIRS, COLUMNS)
    blocks = launch(kernels.stiffness, shape, inputs, shape, types.scalar)
    close(blocks, np.einsum("rk,rpl->kpl", H, product))


def test_skin_adds_the_basis_times_the_coordinates_to_rest(kernels, types, launch, close):
    rest, B, Q = RNG.standard_normal((11, 3)), RNG.standard_normal((11, COLUMNS)), RNG.standard_normal((COLUMNS, 3))
    inputs = [(rest, types.vec3), (B, types.scalar), (Q, types.vec3)]
    close(launch(kernels.skin, 11, inputs, 11, types.vec3), rest + B @ Q)
