"""The single-precision factor against dense solutions."""

import numpy as np
import pytest
import scipy.sparse as sp

from lingual.model.discretisation import BlockPattern
from lingual.model.multifrontal import MultifrontalCholesky

RNG = np.random.default_rng(5)


class System:
    """A positive definite matrix on a mesh's pattern: independent rank-one terms on its edges plus a diagonal."""

    def __init__(self, mesh):
        pattern = BlockPattern(mesh, np.arange(mesh.node_count))
        self.nodes, self.starts, self.columns = mesh.nodes, pattern.row_starts, pattern.columns
        size = 3 * mesh.node_count
        rows = np.repeat(np.arange(mesh.node_count), np.diff(self.starts))
        A = 0.1 * np.eye(size)
        for a, b in zip(rows, self.columns, strict=True):
            if a < b:
                v = np.zeros(size)
                v[3 * a : 3 * a + 3] = RNG.standard_normal(3)
                v[3 * b : 3 * b + 3] = RNG.standard_normal(3)
                at = np.flatnonzero(v)
                A[np.ix_(at, at)] += np.outer(v[at], v[at])
        self.dense = A
        self.blocks = np.array(
            [A[3 * a : 3 * a + 3, 3 * b : 3 * b + 3] for a, b in zip(rows, self.columns, strict=True)]
        )

    def factor(self):
        return MultifrontalCholesky(self.nodes, self.starts, self.columns)


@pytest.fixture(scope="module", params=[(1, 1, 1), (6, 4, 3), (12, 4, 5)])
def system(request, block):
    """One front, a few, and many."""
    return System(block((0.05, 0.03, 0.02), request.param))


@pytest.fixture(scope="module")
def factor(system):
    factor = system.factor()
    factor.factorise(system.blocks)
    return factor


def test_a_solution_is_right_to_single_precision(system, factor):
    x = RNG.standard_normal(len(system.dense))
    solved = factor.solve(system.dense @ x)
    assert np.linalg.norm(solved - x) <= 1e-5 * np.linalg.cond(system.dense) ** 0.5 * np.linalg.norm(x)


def test_columns_are_solved_like_vectors_whatever_their_size(system, factor):
    right = RNG.standard_normal((len(system.dense), 3)) * [1.0, 1e20, 1e-30]
    together = factor.solve(right)
    for n in range(3):
        alone = factor.solve(right[:, n])
        assert np.linalg.norm(system.dense @ alone - right[:, n]) <= 1e-3 * np.linalg.norm(right[:, n])
        assert np.linalg.norm(together[:, n] - alone) <= 1e-3 * np.linalg.norm(alone)


def test_the_inverse_is_symmetric_and_positive(system, factor):
    a, b = RNG.standard_normal((2, len(system.dense)))
    assert a @ factor.solve(b) == pytest.approx(b @ factor.solve(a), rel=1e-3, abs=1e-3 * abs(a @ factor.solve(a)))
    assert a @ factor.solve(a) > 0.0


def test_the_result_is_the_same_in_every_run(system, factor):
    right = RNG.standard_normal(len(system.dense))
    first = factor.solve(right)
    again = system.factor()
    again.factorise(2.0 * system.blocks)
    again.factorise(system.blocks)
    np.testing.assert_array_equal(again.solve(right), first)


def test_an_indefinite_matrix_is_refused(system):
    blocks = system.blocks.copy()
    rows = np.repeat(np.arange(len(system.nodes)), np.diff(system.starts))
    blocks[np.flatnonzero(rows == system.columns)[len(system.nodes) // 2]] -= 1e3 * np.eye(3)
    with pytest.raises(np.linalg.LinAlgError):
        system.factor().factorise(blocks)


def test_the_factor_is_far_smaller_than_a_dense_one(block):
    mesh = block((0.06, 0.02, 0.02), (30, 5, 5))
    pattern = BlockPattern(mesh, np.arange(mesh.node_count))
    factor = MultifrontalCholesky(mesh.nodes, pattern.row_starts, pattern.columns)
    assert factor.entry_count < 0.2 * (3 * mesh.node_count) ** 2 / 2


def test_nodes_may_be_numbered_in_any_order(system):
    """The same matrix with its nodes renumbered has the same solution."""
    count = len(system.nodes)
    order = RNG.permutation(count)
    A = sp.bsr_array((system.blocks, system.columns, system.starts), shape=system.dense.shape).toarray()
    unknowns = (3 * order[:, None] + np.arange(3)).ravel()
    shuffled = sp.bsr_array(A[np.ix_(unknowns, unknowns)], blocksize=(3, 3))
    shuffled.sort_indices()
    factor = MultifrontalCholesky(system.nodes[order], shuffled.indptr, shuffled.indices)
    factor.factorise(shuffled.data)
    x = RNG.standard_normal(len(A))
    solved = factor.solve((A @ x)[unknowns])
    assert np.linalg.norm(solved - x[unknowns]) <= 1e-3 * np.linalg.norm(x)
