"""Kernels of the device's conjugate gradients against NumPy."""

import numpy as np
import pytest
import warp as wp

from lingual.kernels.full_space_cg import FOLDED, LANES, full_space_cg_kernels

RNG = np.random.default_rng(3)
NODES = 7
STARTS = np.array([0, 2, 3, 3, 6, 8, 9, 11], dtype=np.int32)
COLUMNS = np.array([0, 4, 1, 3, 5, 6, 4, 0, 5, 6, 3], dtype=np.int32)
BLOCKS = RNG.standard_normal((len(COLUMNS), 3, 3))
X = RNG.standard_normal((NODES, 3))


def row_sums(terms) -> np.ndarray:
    """Sum of the terms (entries, 3) of every row."""
    rows = np.repeat(np.arange(NODES), np.diff(STARTS))
    total = np.zeros((NODES, 3))
    np.add.at(total, rows, terms)
    return total


@pytest.fixture
def kernels():
    return full_space_cg_kernels()


def test_matrix_product_multiplies_the_blocks_of_a_row(kernels, launch):
    inputs = [(BLOCKS, wp.mat33d), (STARTS, wp.int32), (COLUMNS, wp.int32), (X, wp.vec3d)]
    product = launch(kernels.matrix_product, NODES, inputs, NODES, wp.vec3d)
    np.testing.assert_allclose(product, row_sums([B @ X[c] for B, c in zip(BLOCKS, COLUMNS, strict=True)]))


def test_weighted_sum_multiplies_by_scalars(kernels, launch):
    weights = RNG.random(len(COLUMNS))
    inputs = [(weights, wp.float64), (STARTS, wp.int32), (COLUMNS, wp.int32), (X, wp.vec3d)]
    result = launch(kernels.weighted_sum, NODES, inputs, NODES, wp.vec3d)
    np.testing.assert_allclose(result, row_sums(weights[:, None] * X[COLUMNS]))


@pytest.mark.parametrize("count", [5, 3 * LANES + 11])
def test_a_dot_product_of_any_length_is_summed_in_two_stages(kernels, launch, count):
    a, b = RNG.standard_normal((2, count, 3))
    lanes = launch(kernels.dot_lanes, LANES, [(a, wp.vec3d), (b, wp.vec3d)], LANES, wp.float64)
    folded = launch(kernels.fold, FOLDED, [(lanes, wp.float64)], FOLDED, wp.float64)
    assert folded.sum() == pytest.approx(np.sum(a * b), rel=1e-12, abs=1e-10)


def test_a_dense_product_is_the_sum_of_its_parts(kernels, launch):
    matrix = RNG.standard_normal((20, 20))
    matrix += matrix.T
    x = RNG.standard_normal(20)
    parts = launch(kernels.dense_product, (6, 20), [(matrix, wp.float64), (x, wp.float64)], (6, 20), wp.float64)
    total = launch(kernels.sum_parts, 20, [(parts, wp.float64)], 20, wp.float64)
    np.testing.assert_allclose(total, matrix @ x)


def test_precondition_adds_the_local_and_the_coarse_part(kernels, launch):
    inverse, residual = RNG.standard_normal((NODES, 3, 3)), RNG.standard_normal((NODES, 3))
    weights = RNG.random(len(COLUMNS))
    inputs = [(inverse, wp.mat33d), (residual, wp.vec3d), (weights, wp.float64), (STARTS, wp.int32)]
    inputs += [(COLUMNS, wp.int32), (X, wp.vec3d)]
    result = launch(kernels.precondition, NODES, inputs, NODES, wp.vec3d)
    coarse = row_sums(weights[:, None] * X[COLUMNS])
    np.testing.assert_allclose(result, np.einsum("nij,nj->ni", inverse, residual) + coarse)


def test_the_diagonal_is_added_in_place_and_inverted(kernels, device):
    places = wp.array([0, 2, 3], dtype=wp.int32, device=device)
    blocks = wp.array(BLOCKS, dtype=wp.mat33d, device=device)
    diagonal = 5.0 * np.eye(3) + RNG.random((3, 3, 3))
    added = wp.array(diagonal, dtype=wp.mat33d, device=device)
    wp.launch(kernels.add_diagonal, 3, [added, places], [blocks], device=device)
    expected = BLOCKS.copy()
    expected[[0, 2, 3]] += diagonal
    np.testing.assert_allclose(blocks.numpy(), expected)
    inverse = wp.zeros(3, dtype=wp.mat33d, device=device)
    wp.launch(kernels.inverse_diagonal, 3, [blocks, places], [inverse], device=device)
    np.testing.assert_allclose(inverse.numpy(), np.linalg.inv(expected[[0, 2, 3]]))


def test_constraint_products_and_forces(kernels, launch, device):
    rows, solved = RNG.standard_normal((2, 2, NODES, 3))
    parts = launch(kernels.constraint_product, (4, 2), [(rows, wp.vec3d), (X, wp.vec3d)], (4, 2), wp.float64)
    np.testing.assert_allclose(parts.sum(axis=0), np.einsum("rni,ni->r", rows, X))
    y = RNG.standard_normal(2)
    arrays = [wp.array(a, dtype=t, device=device) for a, t in [(rows, wp.vec3d), (solved, wp.vec3d), (y, wp.float64)]]
    direction, residual = (wp.array(X, dtype=wp.vec3d, device=device) for _ in range(2))
    wp.launch(kernels.constraint_force, NODES, [*arrays, direction, residual], device=device)
    np.testing.assert_allclose(direction.numpy(), X - np.einsum("r,rni->ni", y, solved))
    np.testing.assert_allclose(residual.numpy(), X - np.einsum("r,rni->ni", y, rows))


def folded(value: float, device: str) -> wp.array:
    """A dot product as its last few numbers."""
    return wp.array(np.full(FOLDED, value / FOLDED), dtype=wp.float64, device=device)


@pytest.mark.parametrize(("curvature", "length", "flag"), [(4.0, 0.5, 0), (-1.0, 0.0, 1), (0.0, 0.0, 1)])
def test_advance_moves_along_p_unless_the_matrix_curves_down(kernels, device, curvature, length, flag):
    p, q, x, r = RNG.standard_normal((4, NODES, 3))
    P, Q, moved, left = (wp.array(a, dtype=wp.vec3d, device=device) for a in (p, q, x, r))
    indefinite = wp.zeros(1, dtype=wp.int32, device=device)
    inputs = [folded(2.0, device), folded(curvature, device), P, Q]
    wp.launch(kernels.advance, NODES, [*inputs, moved, left, indefinite], device=device)
    np.testing.assert_allclose(moved.numpy(), x + length * p)
    np.testing.assert_allclose(left.numpy(), r - length * q)
    assert indefinite.numpy()[0] == flag


@pytest.mark.parametrize(("previous", "share"), [(4.0, 0.5), (0.0, 0.0)])
def test_turn_makes_the_next_direction(kernels, device, previous, share):
    z, p = RNG.standard_normal((2, NODES, 3))
    direction, turned = (wp.array(a, dtype=wp.vec3d, device=device) for a in (z, p))
    wp.launch(kernels.turn, NODES, [folded(2.0, device), folded(previous, device), direction, turned], device=device)
    np.testing.assert_allclose(turned.numpy(), z + share * p)
