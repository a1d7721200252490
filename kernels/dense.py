"""Dense products out = A B on CUDA, for few columns and for many. On a CPU, BLAS does the same.

A is stored transposed where that makes neighbouring threads read neighbouring numbers.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from .precision import precision

REDUCTION_THREADS = 128
"""Threads of one block that share the sum of one output number."""
TILE_M, TILE_N, TILE_K = 64, 128, 16
"""Shape of the tiles of `product_tiled`: rows and columns of the output, and the depth of one step."""
TILE_THREADS = 128


@cache
def dense_kernels(precision_name: str) -> SimpleNamespace:
    """Kernels `product_rows`, `product_reduce`, `product_tiled` and `sum_parts` of one precision."""
    scalar = precision(precision_name).scalar

    @wp.kernel(module="unique")
    def product_rows(
        A_transposed: wp.array(dtype=scalar, ndim=2),
        B: wp.array(dtype=scalar, ndim=2),
        out: wp.array(dtype=scalar, ndim=2),
    ):
        """One thread writes one number of A B for few columns of B: neighbours share the column."""
        column, row = wp.tid()
        result = scalar(0.0)
        for k in range(A_transposed.shape[0]):
            result += A_transposed[k, row] * B[k, column]
        out[row, column] = result

    @wp.kernel(module="unique")
    def product_reduce(
        A: wp.array(dtype=scalar, ndim=2),
        B: wp.array(dtype=scalar, ndim=2),
        out: wp.array(dtype=scalar, ndim=2),
    ):
        """One block writes one number of A B where the sum is long; its threads take turns along the sum."""
        row, column, lane = wp.tid()
        result = scalar(0.0)
        for k in range(lane, A.shape[1], wp.block_dim()):
            result += A[row, k] * B[k, column]
        wp.tile_store(out[row], wp.tile_sum(wp.tile(result)), offset=column)

    @wp.kernel(module="unique")
    def product_tiled(
        A: wp.array(dtype=scalar, ndim=2),
        B: wp.array(dtype=scalar, ndim=2),
        steps_per_part: int,
        parts_out: wp.array(dtype=scalar, ndim=3),
    ):
        """One block writes one tile of the product over one part of the sum."""
        part, i, j = wp.tid()
        result = wp.tile_zeros(shape=(TILE_M, TILE_N), dtype=scalar)
        for step in range(steps_per_part):
            k = (part * steps_per_part + step) * TILE_K
            a = wp.tile_load(A, shape=(TILE_M, TILE_K), offset=(i * TILE_M, k))
            b = wp.tile_load(B, shape=(TILE_K, TILE_N), offset=(k, j * TILE_N))
            wp.tile_matmul(a, b, result)
        wp.tile_store(parts_out[part], result, offset=(i * TILE_M, j * TILE_N))

    @wp.kernel(module="unique")
    def sum_parts(parts: wp.array(dtype=scalar, ndim=3), out: wp.array(dtype=scalar, ndim=2)):
        """One thread adds up the parts of one number, always in the same order."""
        row, column = wp.tid()
        result = scalar(0.0)
        for part in range(parts.shape[0]):
            result += parts[part, row, column]
        out[row, column] = result

    return SimpleNamespace(
        product_rows=product_rows, product_reduce=product_reduce, product_tiled=product_tiled, sum_parts=sum_parts
    )
