"""Dense products on every device against NumPy, for few columns, many columns and long sums."""

import numpy as np
import pytest
import warp as wp

from lingual.kernels.dense import TILE_K, TILE_M, TILE_N, dense_kernels
from lingual.model.dense_product import DenseProduct


def _random(types, device, *shape):
    values = np.random.default_rng(sum(shape)).standard_normal(shape)
    return values.astype(types.numpy), wp.array(values, dtype=types.scalar, device=device)


@pytest.mark.parametrize(("rows", "inner", "columns"), [(70, 50, 3), (5, 700, 3), (70, 50, 96), (50, 1200, 90)])
def test_a_bound_product_is_the_matrix_product(types, device, close, rows, inner, columns):
    A, _ = _random(types, device, rows, inner)
    B, B_device = _random(types, device, inner, columns)
    out = wp.zeros((rows, columns), dtype=types.scalar, device=device)
    DenseProduct(A, types.numpy.name, device).bind(B_device, out)()
    close(out.numpy(), A @ B)


def test_trailing_dimensions_and_vectors_are_columns(types, device, close):
    A, _ = _random(types, device, 7, 5)
    B, B_device = _random(types, device, 5, 3, 4)
    out = wp.zeros((7, 12), dtype=types.scalar, device=device)
    DenseProduct(A, types.numpy.name, device).bind(B_device, out)()
    close(out.numpy(), A @ B.reshape(5, 12))
    vectors = wp.zeros(7, dtype=types.vec3, device=device)
    DenseProduct(A, types.numpy.name, device).bind(wp.array(B[:, :, 0], dtype=types.vec3, device=device), vectors)()
    close(vectors.numpy(), A @ B[:, :, 0])


def test_an_updated_matrix_is_seen_by_products_bound_before(types, device, close):
    A, _ = _random(types, device, 6, 5)
    B, B_device = _random(types, device, 5, 3)
    out = wp.zeros((6, 3), dtype=types.scalar, device=device)
    product = DenseProduct(A, types.numpy.name, device)
    call = product.bind(B_device, out)
    product.update(2.0 * A)
    call()
    close(out.numpy(), 2.0 * A @ B)


def test_shapes_that_do_not_fit_are_refused(types, device):
    _, B = _random(types, device, 4, 3)
    with pytest.raises(ValueError, match="does not give"):
        DenseProduct(np.zeros((6, 5)), types.numpy.name, device).bind(B, wp.zeros((6, 3), dtype=types.scalar))


@pytest.mark.parametrize("kernel", ["product_rows", "product_reduce", "product_tiled"])
def test_every_kernel_computes_the_product(types, device, close, kernel):
    """Also on a CPU, where BLAS takes their place."""
    A, A_device = _random(types, device, 130, 70)
    B, B_device = _random(types, device, 70, 90)
    kernels = dense_kernels(types.numpy.name)
    out = wp.zeros((130, 90), dtype=types.scalar, device=device)
    block = 1 if device == "cpu" else 64
    if kernel == "product_rows":
        transposed = wp.array(np.ascontiguousarray(A.T), dtype=types.scalar, device=device)
        wp.launch(kernels.product_rows, (90, 130), [transposed, B_device], [out], device=device)
    elif kernel == "product_reduce":
        size = (130, 90, block)
        wp.launch(kernels.product_reduce, size, [A_device, B_device], [out], device=device, block_dim=block)
    else:
        steps = -(-70 // (2 * TILE_K))
        parts = wp.zeros((2, 130, 90), dtype=types.scalar, device=device)
        size = (2, -(-130 // TILE_M), -(-90 // TILE_N), block)
        wp.launch(kernels.product_tiled, size, [A_device, B_device, steps], [parts], device=device, block_dim=block)
        wp.launch(kernels.sum_parts, (130, 90), [parts], [out], device=device)
    close(out.numpy(), A @ B)
