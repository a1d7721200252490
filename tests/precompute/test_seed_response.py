"""Responses to seeds, against the constrained equations written out and solved densely."""

import numpy as np
import pytest

from lingual.model import Material
from lingual.model.discretisation import Discretisation
from lingual.precompute.seed_response import SeedResponse, coordinates_of
from lingual.precompute.seeds import choose_seeds


class DenseResponse:
    """Luo (2017), Eq. 12, with its multipliers: the oracle."""

    def __init__(self, tongue, seeds) -> None:
        discretisation = Discretisation(tongue.mesh, tongue.material)
        discretisation.set_displacement(np.zeros_like(tongue.mesh.nodes))
        self.sparse = discretisation.stiffness().tocsr().copy()
        self.stiffness = self.sparse.toarray()
        self._seeds = [s.nodes for s in seeds]
        self._fixed = tongue.fixed_nodes

    def anchors(self, index: int) -> np.ndarray:
        return np.concatenate([self._fixed, *(s for i, s in enumerate(self._seeds) if i != index)])

    def rows(self, nodes: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Constraint rows that pick the nodes' displacements along `directions` (m, 3)."""
        rows = np.zeros((len(nodes) * len(directions), len(self.stiffness)))
        for k, node in enumerate(nodes):
            rows[k * len(directions) : (k + 1) * len(directions), 3 * node : 3 * node + 3] = directions
        return rows

    def solve(self, force: np.ndarray, rows: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Displacements with rows @ u = values, one column for each column of force."""
        zeros = np.zeros((len(rows), len(rows)))
        whole = np.block([[self.stiffness, rows.T], [rows, zeros]])
        return np.linalg.solve(whole, np.vstack([force, values]))[: len(self.stiffness)]

    def moved(self, index: int, direction: np.ndarray, anchor_directions: np.ndarray) -> np.ndarray:
        """Component along `direction` when seed `index` is moved by it, anchors held along `anchor_directions`."""
        anchors = self.rows(self.anchors(index), anchor_directions)
        seed = self.rows(self._seeds[index], np.eye(3))
        values = np.concatenate([np.zeros(len(anchors)), np.tile(direction, len(self._seeds[index]))])
        u = self.solve(np.zeros((len(self.stiffness), 1)), np.vstack([anchors, seed]), values[:, None])
        return u.reshape(-1, 3) @ direction


@pytest.fixture(scope="module")
def seeds(small_tongue):
    return choose_seeds(small_tongue, 5)


@pytest.fixture(scope="module")
def dense(small_tongue, seeds):
    return DenseResponse(small_tongue, seeds)


@pytest.fixture(scope="module")
def response(small_tongue, seeds, dense):
    return SeedResponse(dense.sparse, seeds, small_tongue.fixed_nodes)


@pytest.mark.parametrize("index", [0, 4])
def test_directions_diagonalise_the_response_to_unit_forces(response, dense, seeds, index):
    nodes = seeds[index].nodes
    force = np.zeros((len(dense.stiffness), 3))
    for axis in range(3):
        force[3 * nodes + axis, axis] = 1.0 / len(nodes)
    rows = dense.rows(dense.anchors(index), np.eye(3))
    u = dense.solve(force, rows, np.zeros((len(rows), 3)))
    A = u.T @ u
    directions = response.directions(index)
    np.testing.assert_allclose(directions @ directions.T, np.eye(3), atol=1e-12)
    diagonal = directions @ A @ directions.T
    assert np.all(np.diff(np.diag(diagonal)) > 0.0)
    np.testing.assert_allclose(diagonal, np.diag(np.diag(diagonal)), atol=1e-9 * diagonal[2, 2])


@pytest.mark.parametrize("direction", [[0.0, 0.0, 1.0], [0.6, 0.0, 0.8]])
def test_anchors_that_hold_or_slide_give_the_solution_of_their_constraints(response, dense, direction):
    p = np.array(direction)
    np.testing.assert_allclose(response.with_anchors_fixed(1, p), dense.moved(1, p, np.eye(3)), atol=1e-9)
    np.testing.assert_allclose(response.with_anchors_sliding(1, p), dense.moved(1, p, p[None]), atol=1e-9)


def test_a_slender_bar_gives_way_across_its_axis_and_least_along_it(block, tongue_of):
    """Flat bar: the principal direction is across its thin side."""
    mesh = block((0.06, 0.016, 0.006), (15, 4, 2))
    middle = np.argmin(np.linalg.norm(mesh.nodes - [0.06, 0.008, 0.003], axis=1))
    bar = tongue_of(mesh, {"TT": int(middle)}, Material(poisson_ratio=0.3))
    seeds = choose_seeds(bar, 1, 0.0)
    response = SeedResponse(DenseResponse(bar, seeds).sparse, seeds, bar.fixed_nodes)
    least, _, principal = np.abs(response.directions(0))
    assert principal[2] > 0.99
    assert least[0] > 0.99


def test_coordinates_of_nodes():
    np.testing.assert_array_equal(coordinates_of(np.array([0, 4])), [0, 1, 2, 12, 13, 14])
