"""Projected conjugate gradients on a device, with a block-diagonal and a coarse preconditioner.

The method is that of projected_cg.py, [A J^T; J 0] [x; y] = [f; g], with P = (D^-1 + Z A_c^-1 Z^T)^-1. One iteration
is a fixed sequence of launches without a read; on CUDA, `CHECKED` of them are one graph, after which the
host looks at r.z once. The coarse matrix is made and inverted on the host from an earlier tangent.
"""

import numpy as np
import scipy.sparse as sp
import warp as wp
from numpy.typing import NDArray

from ..kernels.full_space_cg import FOLDED, LANES, full_space_cg_kernels
from ..model.coarse_space import cell_count, coarse_inverse, trilinear_weights
from .projected_cg import RELATIVE_TOLERANCE

CHECKED = 10
"""Iterations between two looks of the host."""
MAXIMUM_ITERATIONS = 1000
PARTS = 16
"""Threads that share one row of a dense product."""
CONSTRAINT_PARTS = 256


class DeviceConjugateGradients:
    """Solves systems of one block pattern on one device.

    points: places of the nodes [m], (n, 3). row_starts, columns: pattern of the 3x3 blocks. `set_matrix` and
    `renew` come before `solve`. iterations: of the last solution.
    """

    def __init__(
        self, points: NDArray[np.float64], row_starts: NDArray[np.integer], columns: NDArray[np.integer], device: str
    ) -> None:
        self.device, self.iterations = device, 0
        self._kernels = full_space_cg_kernels()
        self._count = len(points)
        self._pattern = columns, row_starts
        rows = np.repeat(np.arange(len(points)), np.diff(row_starts))
        self._row_starts, self._columns = self._integers(row_starts), self._integers(columns)
        self._diagonal_places = self._integers(np.flatnonzero(rows == columns))
        self._weights = trilinear_weights(points, cell_count(len(points)))
        self._prolongation = self._sparse(self._weights)
        self._restriction = self._sparse(sp.csr_array(self._weights.T))
        vectors = {name: wp.zeros(len(points), dtype=wp.vec3d, device=device) for name in "xrzpq"}
        self._x, self._r, self._z, self._p, self._q = vectors.values()
        self._inverse_diagonal = wp.zeros(len(points), dtype=wp.mat33d, device=device)
        self._lanes, self._current, self._previous, self._curvature = (
            self._numbers(n) for n in (LANES, FOLDED, FOLDED, FOLDED)
        )
        self._indefinite = wp.zeros(1, dtype=wp.int32, device=device)
        size = 3 * self._weights.shape[1]
        self._restricted, self._restricted_vectors = self._paired(size)
        self._coarse, self._coarse_vectors = self._paired(size)
        self._coarse_parts = self._numbers((PARTS, size))
        self._coarse_inverse = self._numbers((size, size))
        self._blocks: wp.array | None = None
        self._ready = False
        self._graph: wp.Graph | None = None

    def _integers(self, values: NDArray[np.integer]) -> wp.array:
        return wp.array(np.asarray(values, dtype=np.int32), dtype=wp.int32, device=self.device)

    def _numbers(self, shape: int | tuple[int, ...]) -> wp.array:
        return wp.zeros(shape, dtype=wp.float64, device=self.device)

    def _vectors(self, values: NDArray[np.float64]) -> wp.array:
        return wp.array(values, dtype=wp.vec3d, device=self.device)

    def _sparse(self, W: sp.csr_array) -> list[wp.array]:
        weights: wp.array = wp.array(W.data, dtype=wp.float64, device=self.device)
        return [weights, self._integers(W.indptr), self._integers(W.indices)]

    def _paired(self, size: int) -> tuple[wp.array, wp.array]:
        """The same memory as numbers and as vectors."""
        numbers = self._numbers(size)
        return numbers, wp.array(ptr=numbers.ptr, shape=(size // 3,), dtype=wp.vec3d, device=self.device)

    def _launch(self, kernel: wp.Kernel, dim: int | tuple[int, ...], inputs: list, outputs: list) -> None:
        wp.launch(kernel, dim, inputs, outputs, device=self.device)

    def set_matrix(self, blocks: wp.array) -> None:
        """Takes A's blocks, (block_count,) of mat33d on the device; they are used in place."""
        if self._blocks is None or self._blocks.ptr != blocks.ptr:
            self._graph = None
        self._blocks = blocks
        inputs = [blocks, self._diagonal_places]
        self._launch(self._kernels.inverse_diagonal, self._count, inputs, [self._inverse_diagonal])
        if self._ready:
            self._solve_rows()

    @property
    def ready(self) -> bool:
        """Whether there are a coarse matrix and constraint rows."""
        return self._ready

    def forget(self) -> None:
        self._ready = False

    def renew(self, J: NDArray[np.float64]) -> None:
        """Makes the coarse matrix from the present A and takes the constraint rows J (m, 3 n).

        Raises numpy.linalg.LinAlgError when the rows repeat each other.
        """
        assert self._blocks is not None
        size = 3 * self._count
        A = sp.bsr_array((self._blocks.numpy(), *self._pattern), shape=(size, size))
        self._coarse_inverse.assign(coarse_inverse(A, self._weights))
        self._J = J
        self._ready = False
        self._graph = None
        if len(J):
            self._rows = self._vectors(J.reshape(len(J), -1, 3))
            self._solved_rows = wp.zeros_like(self._rows)
            self._schur_inverse = self._numbers((len(J), len(J)))
            self._row_parts = self._numbers((CONSTRAINT_PARTS, len(J)))
            self._schur_parts = self._numbers((PARTS, len(J)))
            self._products, self._change, self._y = (self._numbers(len(J)) for _ in range(3))
        self._solve_rows()
        self._ready = True

    def _solve_rows(self) -> None:
        """P^-1 J^T and the inverse of J P^-1 J^T, for the present diagonal and coarse matrix."""
        J = self._J
        solved = np.empty((len(J), 3 * self._count))
        for n, row in enumerate(J):
            solved[n] = self._preconditioned(row)
        self._host_schur_inverse = np.linalg.inv(J @ solved.T)
        self._host_solved = solved
        if len(J):
            self._solved_rows.assign(solved.reshape(len(J), -1, 3))
            self._schur_inverse.assign(self._host_schur_inverse)

    def _preconditioned(self, f: NDArray[np.float64]) -> NDArray[np.float64]:
        self._r.assign(f.reshape(-1, 3))
        self._precondition()
        return self._z.numpy().ravel().copy()

    def _precondition(self) -> None:
        """z = D^-1 r + Z A_c^-1 Z^T r."""
        k, size = self._kernels, len(self._coarse)
        self._launch(k.weighted_sum, size // 3, [*self._restriction, self._r], [self._restricted_vectors])
        inputs = [self._coarse_inverse, self._restricted]
        self._launch(k.dense_product, (PARTS, size), inputs, [self._coarse_parts])
        self._launch(k.sum_parts, size, [self._coarse_parts], [self._coarse])
        inputs = [self._inverse_diagonal, self._r, *self._prolongation, self._coarse_vectors]
        self._launch(k.precondition, self._count, inputs, [self._z])

    def _project(self) -> None:
        """Moves z into the null space of J and takes its multipliers from r."""
        if not len(self._J):
            return
        k, rows = self._kernels, len(self._J)
        self._launch(k.constraint_product, (CONSTRAINT_PARTS, rows), [self._rows, self._z], [self._row_parts])
        self._launch(k.sum_parts, rows, [self._row_parts], [self._products])
        self._launch(k.dense_product, (PARTS, rows), [self._schur_inverse, self._products], [self._schur_parts])
        self._launch(k.sum_parts, rows, [self._schur_parts], [self._change])
        inputs = [self._rows, self._solved_rows, self._change]
        self._launch(k.constraint_force, self._count, inputs, [self._z, self._r])
        self._launch(k.accumulate, rows, [self._change], [self._y])

    def _dot(self, a: wp.array, b: wp.array, folded: wp.array) -> None:
        self._launch(self._kernels.dot_lanes, LANES, [a, b], [self._lanes])
        self._launch(self._kernels.fold, FOLDED, [self._lanes], [folded])

    def _multiply(self, x: wp.array) -> None:
        """q = A x."""
        inputs = [self._blocks, self._row_starts, self._columns, x]
        self._launch(self._kernels.matrix_product, self._count, inputs, [self._q])

    def _iterate(self) -> None:
        """One iteration; z is D^-1 r + ... at its start and at its end."""
        self._project()
        self._dot(self._r, self._z, self._current)
        self._launch(self._kernels.turn, self._count, [self._current, self._previous, self._z], [self._p])
        wp.copy(self._previous, self._current)
        self._multiply(self._p)
        self._dot(self._p, self._q, self._curvature)
        inputs = [self._current, self._curvature, self._p, self._q]
        self._launch(self._kernels.advance, self._count, inputs, [self._x, self._r, self._indefinite])
        self._precondition()

    def _iterate_checked(self) -> None:
        if not wp.get_device(self.device).is_cuda:
            for _ in range(CHECKED):
                self._iterate()
            return
        if self._graph is None:
            self._iterate()  # loads every kernel before the capture; one iteration more does no harm
            with wp.ScopedCapture(device=self.device) as capture:
                for _ in range(CHECKED):
                    self._iterate()
            self._graph = capture.graph
        wp.capture_launch(self._graph)

    def solve(self, f: NDArray[np.float64], g: NDArray[np.float64]) -> tuple[NDArray, NDArray]:
        """x (3 n,) and multipliers y (m,).

        Raises numpy.linalg.LinAlgError when A curves down in the constraints' null space, or after
        MAXIMUM_ITERATIONS.
        """
        x = self._preconditioned(f)
        y = self._host_schur_inverse @ (self._J @ x - g)
        x -= self._host_solved.T @ y
        self._x.assign(x.reshape(-1, 3))
        self._multiply(self._x)
        self._r.assign((f - self._J.T @ y).reshape(-1, 3) - self._q.numpy())
        first = abs(float(f @ x)) + abs(float(g @ y))
        for array in (self._previous, self._indefinite):
            array.zero_()
        if len(self._J):
            self._y.zero_()
        self._precondition()
        self.iterations = 0
        while self.iterations < MAXIMUM_ITERATIONS:
            self._iterate_checked()
            self.iterations += CHECKED
            if self._indefinite.numpy()[0]:
                raise np.linalg.LinAlgError("the matrix is not positive definite")
            if float(self._current.numpy().sum()) <= RELATIVE_TOLERANCE**2 * first:
                return self._x.numpy().ravel().copy(), y + (self._y.numpy() if len(self._J) else 0.0)
        raise np.linalg.LinAlgError("conjugate gradients did not converge")
