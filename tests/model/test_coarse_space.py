"""Trilinear functions on a box grid."""

import numpy as np
import pytest
import scipy.sparse as sp

from lingual.model.coarse_space import cell_count, coarse_inverse, coarse_matrix, trilinear_weights

RNG = np.random.default_rng(6)


@pytest.mark.parametrize("cells", [1, 3, 6])
def test_weights_are_shares_that_sum_to_one(cells):
    W = trilinear_weights(RNG.random((200, 3)) * [3.0, 2.0, 1.0], cells)
    assert W.data.min() > 0.0
    np.testing.assert_allclose(W.sum(axis=1), 1.0)
    assert (W.sum(axis=0) > 0.0).all()


def test_linear_fields_are_in_the_span():
    points = RNG.random((300, 3)) * [3.0, 2.0, 1.0]
    W = trilinear_weights(points, 4).toarray()
    shares, *_ = np.linalg.lstsq(W, points, rcond=None)
    np.testing.assert_allclose(W @ shares, points, atol=1e-12)


def test_flat_sets_of_points_have_a_grid_too():
    points = RNG.random((50, 3)) * [1.0, 1.0, 0.0]
    np.testing.assert_allclose(trilinear_weights(points, 3).sum(axis=1), 1.0)


def test_the_coarse_matrix_is_the_matrix_between_coarse_functions():
    points = RNG.random((30, 3))
    root = RNG.standard_normal((90, 90))
    A, W = root @ root.T, trilinear_weights(points, 2)
    Z = np.kron(W.toarray(), np.eye(3))
    np.testing.assert_allclose(coarse_matrix(sp.bsr_array(A, blocksize=(3, 3)), W), Z.T @ A @ Z)


def test_the_inverse_survives_functions_that_depend_on_each_other():
    """More vertices than points: Z^T A Z is singular, Z (Z^T A Z)^-1 Z^T is nevertheless the projected inverse."""
    points = RNG.random((10, 3))
    W = trilinear_weights(points, 4)
    assert W.shape[1] > len(points)
    root = RNG.standard_normal((30, 30))
    A = root @ root.T + np.eye(30)
    inverse = coarse_inverse(sp.bsr_array(A, blocksize=(3, 3)), W)
    np.testing.assert_array_equal(inverse, inverse.T)
    Z = np.kron(W.toarray(), np.eye(3))
    np.testing.assert_allclose(Z @ inverse @ Z.T @ A, np.eye(30), atol=1e-4)


def test_the_grid_grows_with_the_mesh():
    assert [cell_count(n) for n in (1, 160, 10_240)] == [1, 2, 8]
