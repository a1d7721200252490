"""The elimination order and its symbolic factor against a dense Cholesky factor."""

import numpy as np
import pytest
import scipy.sparse as sp

from lingual.model.discretisation import BlockPattern
from lingual.model.nested_dissection import dissect


@pytest.fixture(scope="module")
def graph(block):
    """Points and pattern of a bar of 567 nodes."""
    mesh = block((0.06, 0.02, 0.02), (20, 2, 8))
    pattern = BlockPattern(mesh, np.arange(mesh.node_count))
    return mesh.nodes, pattern.row_starts, pattern.columns


@pytest.fixture(scope="module")
def tree(graph):
    return dissect(*graph)


def test_every_node_is_eliminated_once(tree, graph):
    np.testing.assert_array_equal(np.sort(tree.order), np.arange(len(graph[0])))
    assert [f.start for f in tree.fronts[1:]] == [f.end for f in tree.fronts[:-1]]
    assert len(tree.fronts) > 7


def test_children_come_first_and_hand_all_their_boundary_to_their_parent(tree):
    parents = [0] * len(tree.fronts)
    for n, front in enumerate(tree.fronts):
        nodes = np.concatenate([np.arange(front.start, front.end), front.boundary])
        for child in front.children:
            assert child < n
            parents[child] += 1
            assert np.isin(tree.fronts[child].boundary, nodes).all()
    assert parents == [1] * (len(tree.fronts) - 1) + [0]


def test_the_fronts_hold_every_entry_of_the_factor(tree, graph):
    _, starts, columns = graph
    size = len(tree.order)
    adjacency = sp.csr_array((np.ones(len(columns)), columns, starts), shape=(size, size)).toarray()
    ordered = adjacency[np.ix_(tree.order, tree.order)]
    factor = np.linalg.cholesky(ordered + 30.0 * np.eye(size)) != 0.0
    held = np.zeros((size, size), dtype=bool)
    for front in tree.fronts:
        held[front.start : front.end, front.start : front.end] = True
        held[front.boundary, front.start : front.end] = True
    assert not (factor & ~held).any()


def test_separators_are_thin_so_that_the_factor_is_smaller_than_by_coordinate(tree, graph):
    """The bar has 20 sections of 27 nodes: separators are of about that size, not of the bar's length of 21 x 3."""
    tops = [front.end - front.start for front in tree.fronts if front.children]
    assert max(tops) <= 27


def test_a_few_nodes_are_one_front(graph):
    points, starts, columns = np.eye(3), np.array([0, 2, 5, 7]), np.array([0, 1, 0, 1, 2, 1, 2])
    tree = dissect(points, starts, columns)
    assert len(tree.fronts) == 1
    assert len(tree.fronts[0].boundary) == 0
