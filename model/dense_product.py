"""Products with a constant dense matrix, bound once to the arrays that they read and write.

`DenseProduct(A).bind(B, out)` returns a call that computes out = A B: BLAS on views of the arrays on a CPU,
recorded kernel launches on CUDA. The calls allocate nothing and read nothing back, so that a CUDA graph
can capture them.
"""

from collections.abc import Callable
from copy import copy
from math import prod

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.dense import REDUCTION_THREADS, TILE_K, TILE_M, TILE_N, TILE_THREADS, dense_kernels
from ..kernels.precision import precision

Stage = Callable[[], None]
"""One recorded piece of a step."""

FEW_COLUMNS = 32
"""Below so many columns the product is a handful of matrix-vector products."""
LONG_SUM = 512
"""From so many terms on, one number of such a product is worth a block of threads."""
FEW_NUMBERS = 1024
"""Below so many numbers there are too few threads with one each."""
STEPS_AT_LEAST = 4
"""Steps of TILE_K that a part of a sum has at least."""
BLOCKS_WANTED = 264
"""Blocks that keep a large GPU busy: long sums are cut in parts until there are so many."""


class DenseProduct:
    """A of out = A B. A: (m, n); copied to `device` in `precision_name`."""

    def __init__(self, A: NDArray[np.floating], precision_name: str = "float64", device: str = "cpu") -> None:
        p = precision(precision_name)
        self.shape = A.shape
        self.device = device
        self._scalar = p.scalar
        self._kernels = dense_kernels(precision_name)
        # By columns where they are long: BLAS has only the few columns of B to share each number of A with.
        self._A = np.array(A, dtype=p.numpy, order="F" if A.shape[0] > A.shape[1] else "C")
        self._on_device: dict[str, wp.array] = {}

    def _matrix(self, transposed: bool) -> wp.array:
        name = "transposed" if transposed else "plain"
        if name not in self._on_device:
            A = np.ascontiguousarray(self._A.T if transposed else self._A)
            self._on_device[name] = wp.array(A, dtype=self._scalar, device=self.device)
        return self._on_device[name]

    def update(self, A: NDArray[np.floating]) -> None:
        """Replaces the numbers of A, seen by every bound call."""
        self._A[:] = A
        for name, array in self._on_device.items():
            array.assign(np.ascontiguousarray(self._A.T if name == "transposed" else self._A))

    def transposed(self) -> "DenseProduct":
        """Products with A^T, from the same memory on a host: what the caches hold serves both."""
        return self._sharing(self._A.T)

    def head(self, rows: int) -> "DenseProduct":
        """Products with the first rows of A, from the same memory on a host."""
        return self._sharing(self._A[:rows])

    def _sharing(self, A: NDArray[np.floating]) -> "DenseProduct":
        other = copy(self)
        other.shape, other._A, other._on_device = A.shape, A, {}
        return other

    def bind(self, B: wp.array, out: wp.array) -> Stage:
        """A call that computes out = A B. B: (n, ...), out: (m, ...), contiguous, on the same device.

        Trailing dimensions are taken together as columns.
        """
        B2, out2 = _as_matrix(B, self._scalar), _as_matrix(out, self._scalar)
        if B2.shape[0] != self.shape[1] or out2.shape != (self.shape[0], B2.shape[1]):
            raise ValueError(f"{self.shape} times {B2.shape} does not give {out2.shape}")
        if wp.get_device(self.device).is_cpu:
            return _bind_blas(self._A, B2.numpy(), out2.numpy())
        if B2.shape[1] >= FEW_COLUMNS:
            return _bind_tiled(self._matrix(False), B2, out2)
        return self._bind_few(B2, out2)

    def _bind_few(self, B: wp.array, out: wp.array) -> Stage:
        rows, columns = out.shape
        if self.shape[1] >= LONG_SUM or rows * columns < FEW_NUMBERS:
            return _bind_reduced(self._matrix(False), B, out)
        return wp.launch(
            self._kernels.product_rows,
            (columns, rows),
            [self._matrix(True), B],
            [out],
            device=self.device,
            block_dim=64,
            record_cmd=True,
        ).launch


def bind_product(A: wp.array, B: wp.array, out: wp.array) -> Stage:
    """A call that computes out = A B for arrays (m, n), (n, c) and (m, c) that may all change."""
    if wp.get_device(A.device).is_cpu:
        return _bind_blas(A.numpy(), B.numpy(), out.numpy())
    return _bind_tiled(A, B, out) if out.shape[1] >= FEW_COLUMNS else _bind_reduced(A, B, out)


def _bind_blas(A: NDArray, B: NDArray, out: NDArray) -> Stage:
    matmul = np.matmul

    def call() -> None:
        matmul(A, B, out=out)

    return call


def _bind_reduced(A: wp.array, B: wp.array, out: wp.array) -> Stage:
    """One block a number."""
    kernels = dense_kernels(np.dtype(wp.dtype_to_numpy(A.dtype)).name)
    return wp.launch(
        kernels.product_reduce,
        (*out.shape, REDUCTION_THREADS),
        [A, B],
        [out],
        device=A.device,
        block_dim=REDUCTION_THREADS,
        record_cmd=True,
    ).launch


def _bind_tiled(A: wp.array, B: wp.array, out: wp.array) -> Stage:
    """Tiles of the product, a long sum in parts that are added up in the same order every time."""
    kernels = dense_kernels(np.dtype(wp.dtype_to_numpy(A.dtype)).name)
    rows, columns = out.shape
    tiles = -(-rows // TILE_M), -(-columns // TILE_N)
    steps = -(-A.shape[1] // TILE_K)
    part_count = max(1, min(steps // STEPS_AT_LEAST, BLOCKS_WANTED // (tiles[0] * tiles[1])))
    steps_per_part = -(-steps // part_count)
    part_count = -(-steps // steps_per_part)
    whole = part_count == 1
    shape = (part_count, rows, columns)
    parts: wp.array = out.reshape(shape) if whole else wp.empty(shape, dtype=A.dtype, device=A.device)
    product = wp.launch(
        kernels.product_tiled,
        (part_count, *tiles, TILE_THREADS),
        [A, B, steps_per_part],
        [parts],
        device=A.device,
        block_dim=TILE_THREADS,
        record_cmd=True,
    )
    if whole:
        return product.launch
    total = wp.launch(kernels.sum_parts, (rows, columns), [parts], [out], device=A.device, record_cmd=True)

    def call() -> None:
        product.launch()
        total.launch()

    return call


def _as_matrix(array: wp.array, scalar: type) -> wp.array:
    """The same memory as (rows, columns) of scalars; vectors and matrices become columns."""
    columns = prod(array.shape[1:]) * wp.types.type_size(array.dtype) // wp.types.type_size(scalar)
    if array.dtype is scalar:
        return array.reshape((array.shape[0], columns))
    matrix: wp.array = wp.array(ptr=array.ptr, shape=(array.shape[0], columns), dtype=scalar, device=array.device)
    matrix._ref = array  # type: ignore[assignment]  # the memory stays as long as the view
    return matrix
