"""Cholesky factorisation of a mesh's stiffness in float32 by dense fronts, made to precondition.

A = P^T L L^T P with the nodes in the order of nested dissection. Every front of the elimination tree is a dense
matrix [F11 F21^T; F21 F22], to which the blocks of A and the update matrices of its children are added
(multifrontal method, Duff and Reid 1983; Liu 1992). With F11 = L11 L11^T its panel becomes
[L11^-1; F21 L11^-T L11^-1], its update matrix F22 - L21 L21^T. A solution is then one dense product a front
downwards and one upwards, limited by memory bandwidth; single precision halves that and leaves a relative
error of about 1e-4, which the caller's iteration removes.
"""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import cache

import numpy as np
import warp as wp
from numpy.typing import NDArray
from scipy.linalg import blas, lapack

from ..kernels.multifrontal import multifrontal_kernels
from .nested_dissection import Front, dissect


class MultifrontalCholesky:
    """Factor of symmetric positive definite matrices of one block pattern.

    points: place of each node [any unit], (n, 3). row_starts, columns: pattern of the 3x3 blocks, as in
    scipy.sparse.bsr_array, symmetric and with the diagonal. `factorise` comes before `solve`. The subtrees below
    the root are worked on by two threads, with the same result as by one.
    """

    def __init__(
        self, points: NDArray[np.float64], row_starts: NDArray[np.integer], columns: NDArray[np.integer]
    ) -> None:
        tree = dissect(points, row_starts, columns)
        self._fronts = tree.fronts
        self._order = (3 * tree.order[:, None] + np.arange(3)).ravel()
        self._layout = _Layout(tree.fronts)
        self._entries = _entries(tree.fronts, tree.order, self._layout, row_starts, columns)
        self._panel = wp.zeros(self._layout.panel_size, dtype=wp.float32, device="cpu")
        self._update = wp.zeros(self._layout.update_size, dtype=wp.float32, device="cpu")
        self._places, self._place_offset = _places(tree.fronts)
        self._root = len(tree.fronts) - 1
        ends = tree.fronts[self._root].children
        self._branches = [range(a, b + 1) for a, b in zip([0, *(end + 1 for end in ends)], ends, strict=False)]
        self._panels = [self._panel_view(f) for f in range(len(tree.fronts))]
        self._updates = [self._update_view(f) for f in range(len(tree.fronts))]
        self._rows = _FrontRows.of(tree.fronts)

    @property
    def entry_count(self) -> int:
        """Numbers in the factor."""
        return self._layout.panel_size

    def factorise(self, blocks: NDArray[np.floating]) -> None:
        """Takes the matrix with these 3x3 blocks, (block_count, 3, 3) in the order of the pattern.

        Raises numpy.linalg.LinAlgError when it is not positive definite; the factor is then unusable.
        """
        self._panel.zero_()
        single: wp.array = wp.array(blocks, dtype=wp.mat33f, device="cpu")
        kernel = multifrontal_kernels().place_blocks
        wp.launch(kernel, len(self._entries[0]), [single, *self._entries], [self._panel], device="cpu")
        self._in_branches(self._eliminate_branch)
        self._eliminate(self._root)

    def _in_branches(self, work: Callable[[int], None]) -> None:
        """Calls work(branch) for each child of the root, in two threads when there are two."""
        if len(self._branches) == 2:
            other = _worker().submit(work, 1)
            try:
                work(0)
            finally:
                other.result()
        else:
            for branch in range(len(self._branches)):
                work(branch)

    def _eliminate_branch(self, branch: int) -> None:
        for front in self._branches[branch]:
            self._eliminate(front)

    def _panel_view(self, front: int) -> NDArray[np.float32]:
        """(own + boundary, own) view, column by column."""
        own, boundary = self._layout.sizes[front]
        offset = self._layout.panel_offset[front]
        return self._panel.numpy()[offset : offset + own * (own + boundary)].reshape(own, own + boundary).T

    def _update_view(self, front: int) -> NDArray[np.float32]:
        """(boundary, boundary) view, column by column."""
        size = self._layout.sizes[front][1]
        offset = self._layout.update_offset[front]
        return self._update.numpy()[offset : offset + size * size].reshape(size, size).T

    def _eliminate(self, front: int) -> None:
        own, boundary = self._layout.sizes[front]
        panel, update = self._panels[front], self._updates[front]
        update[:] = 0.0
        self._add_children(front)
        if not own:
            return
        factor, failed = lapack.spotrf(np.asfortranarray(panel[:own]), lower=1, clean=1, overwrite_a=1)
        if failed:
            raise np.linalg.LinAlgError("the matrix is not positive definite")
        inverse, _ = lapack.strtri(factor, lower=1, overwrite_c=1)
        panel[:own] = inverse
        if boundary:
            below = blas.strmm(1.0, inverse, np.asfortranarray(panel[own:]), side=1, lower=1, trans_a=1, overwrite_b=1)
            blas.ssyrk(-1.0, below, beta=1.0, c=update, lower=1, overwrite_c=1)
            panel[own:] = blas.strmm(1.0, inverse, below, side=1, lower=1, overwrite_b=1)

    def _add_children(self, front: int) -> None:
        own, boundary = self._layout.sizes[front]
        parent = [own // 3, self._layout.panel_offset[front], self._layout.update_offset[front], boundary]
        for child in self._fronts[front].children:
            size = self._layout.sizes[child][1]
            source = [self._update, self._layout.update_offset[child], size, self._places, self._place_offset[child]]
            wp.launch(
                multifrontal_kernels().extend_add,
                size // 3,
                [*source, *parent],
                [self._panel, self._update],
                device="cpu",
            )

    def solve(self, right: NDArray[np.floating]) -> NDArray[np.float64]:
        """x of A x = right, for right (3 n,) or columns (3 n, m), to about four digits."""
        scale = np.abs(right).max(axis=0)  # float32 has a narrow range
        scale = np.where(scale > 0.0, scale, 1.0)
        x = (right[self._order] / scale).astype(np.float32)
        top = x[3 * self._fronts[self._root].start :]
        carried = [np.zeros_like(top) for _ in self._branches]
        self._in_branches(lambda branch: self._forward(self._branches[branch], x, carried[branch]))
        for part in carried:
            top -= part
        self._forward(range(self._root, self._root + 1), x, top)
        self._backward(range(self._root, self._root + 1), x)
        self._in_branches(lambda branch: self._backward(self._branches[branch], x))
        solution = np.empty(x.shape)
        solution[self._order] = x
        solution *= scale
        return solution

    def _forward(self, fronts: range, x: NDArray[np.float32], carried: NDArray[np.float32]) -> None:
        """x <- L^-1 x on the rows of these fronts; what they subtract from the root's rows is added to `carried`."""
        for f in fronts:
            rows = self._rows[f]
            product = self._panels[f] @ x[rows.own]
            own = rows.own.stop - rows.own.start
            x[rows.own] = product[:own]
            x[rows.inner] -= product[own : own + len(rows.inner)]
            carried[rows.root] += product[own + len(rows.inner) :]

    def _backward(self, fronts: range, x: NDArray[np.float32]) -> None:
        """x <- L^-T x on the rows of these fronts, whose later rows are final."""
        for f in reversed(fronts):
            rows, panel = self._rows[f], self._panels[f]
            own = rows.own.stop - rows.own.start
            part = panel[:own].T @ x[rows.own]
            if len(rows.boundary):
                part -= panel[own:].T @ x[rows.boundary]
            x[rows.own] = part


@dataclass(frozen=True)
class _FrontRows:
    """Unknowns of one front in elimination order.

    own: those it eliminates. boundary: those it couples them with; `inner` the ones before the root's, `root` the
    others, counted from the root's first.
    """

    own: slice
    boundary: NDArray[np.int64]
    inner: NDArray[np.int64]
    root: NDArray[np.int64]

    @classmethod
    def of(cls, fronts: tuple[Front, ...]) -> "list[_FrontRows]":
        result = []
        first = 3 * fronts[-1].start
        for front in fronts:
            rows = (3 * front.boundary[:, None] + np.arange(3)).ravel()
            own = slice(3 * front.start, 3 * front.end)
            result.append(cls(own, rows, rows[rows < first], rows[rows >= first] - first))
        return result


@cache
def _worker() -> ThreadPoolExecutor:
    return ThreadPoolExecutor(1, thread_name_prefix="multifrontal")


class _Layout:
    """Where panels and update matrices lie in their arrays.

    sizes: (own, boundary) unknowns of each front. Update matrices share memory: a child's is free again once
    its parent has taken it. The branches below the root never share, as two threads work on them.
    """

    def __init__(self, fronts: tuple[Front, ...]) -> None:
        self.sizes = [(3 * (f.end - f.start), 3 * len(f.boundary)) for f in fronts]
        self.panel_offset = np.cumsum([0] + [own * (own + boundary) for own, boundary in self.sizes]).tolist()
        self.panel_size = self.panel_offset.pop()
        self.update_offset = [0] * len(fronts)
        self.update_size = 0
        first = 0
        for branch_root in fronts[-1].children:
            self.update_size = self._stack(fronts, range(first, branch_root + 1), self.update_size)
            first = branch_root + 1

    def _stack(self, fronts: tuple[Front, ...], branch: range, base: int) -> int:
        """Places the update matrices of one branch from `base` on, each at the first gap; the end of the memory."""
        taken: list[tuple[int, int]] = []
        end = base
        for f in branch:
            size = self.sizes[f][1] ** 2
            offset = base
            for begin, stop in sorted(taken):
                if begin - offset >= size:
                    break
                offset = max(offset, stop)
            self.update_offset[f] = offset
            end = max(end, offset + size)
            freed = {(self.update_offset[c], self.update_offset[c] + self.sizes[c][1] ** 2) for c in fronts[f].children}
            taken = [span for span in taken if span not in freed]
            if size:
                taken.append((offset, offset + size))
        return end


def _entries(
    fronts: tuple[Front, ...],
    order: NDArray[np.int64],
    layout: _Layout,
    row_starts: NDArray[np.integer],
    columns: NDArray[np.integer],
) -> list[wp.array]:
    """For each lower block of the matrix: its index, the place of its first number in a panel, rows of the panel."""
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order))
    row, column = place[np.repeat(np.arange(len(order)), np.diff(row_starts))], place[columns]
    block = np.flatnonzero(row >= column)
    owner = np.searchsorted([f.end for f in fronts], column[block], side="right")
    sequence = np.argsort(owner, kind="stable")
    block, owner = block[sequence], owner[sequence]
    splits = np.searchsorted(owner, np.arange(len(fronts) + 1))
    offset, rows = np.empty(len(block), dtype=np.int64), np.empty(len(block), dtype=np.int64)
    for f, front in enumerate(fronts):
        part = slice(splits[f], splits[f + 1])
        nodes = np.concatenate([np.arange(front.start, front.end), front.boundary])
        r, c = np.searchsorted(nodes, row[block[part]]), column[block[part]] - front.start
        rows[part] = 3 * len(nodes)
        offset[part] = layout.panel_offset[f] + 3 * c * rows[part] + 3 * r
    return [wp.array(a.astype(np.int32), dtype=wp.int32, device="cpu") for a in (block, offset, rows)]


def _places(fronts: tuple[Front, ...]) -> tuple[wp.array, list[int]]:
    """For each front, where its boundary nodes are among its parent's nodes; all in one array, and each one's start."""
    places, starts, total = [np.zeros(0, dtype=np.int64)], [0] * len(fronts), 0
    for front in fronts:
        nodes = np.concatenate([np.arange(front.start, front.end), front.boundary])
        for child in front.children:
            starts[child] = total
            places.append(np.searchsorted(nodes, fronts[child].boundary))
            total += len(places[-1])
    return wp.array(np.concatenate(places).astype(np.int32), dtype=wp.int32, device="cpu"), starts
