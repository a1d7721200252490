"""The blended quadratic basis: orthonormal in the mass, and spanning what it is to span."""

import numpy as np
import pytest

from lingual.model import LingualError
from lingual.precompute.basis import blended_quadratic_basis, quadratic_functions
from lingual.precompute.domain_weights import domain_weights
from lingual.precompute.seeds import choose_seeds


@pytest.fixture(scope="module")
def domains(small_tongue):
    """Seeds, weights and basis of five domains."""
    seeds = choose_seeds(small_tongue, 5)
    weights = domain_weights(small_tongue, seeds)
    return seeds, weights, blended_quadratic_basis(small_tongue, seeds, weights)


def test_the_basis_is_mass_orthonormal(small_tongue, domains):
    B = domains[2]
    assert B.shape == (small_tongue.mesh.node_count, 50)
    gram = B.T @ (small_tongue.node_masses[:, None] * B)
    np.testing.assert_allclose(gram, np.eye(50), rtol=0, atol=1e-10)


def test_the_basis_vanishes_at_held_nodes(small_tongue, domains):
    B = domains[2]
    assert abs(B[small_tongue.fixed_nodes]).max() < 1e-13 * abs(B).max()


def test_every_weighted_quadratic_is_in_its_span(small_tongue, domains):
    """Quadratics in plain coordinates about another origin: the span does not depend on the scaling."""
    _, weights, B = domains
    functions = quadratic_functions(small_tongue.mesh.nodes, np.array([0.01, -0.02, 0.03]), 0.05)
    blended = np.hstack([w[:, None] * functions for w in weights.T])
    projected = B @ (B.T @ (small_tongue.node_masses[:, None] * blended))
    np.testing.assert_allclose(projected, blended, rtol=0, atol=1e-9 * abs(blended).max())


def test_there_are_ten_functions_complete_to_second_order():
    x = np.random.default_rng(10).standard_normal((40, 3))
    functions = quadratic_functions(x, np.zeros(3), 1.0)
    assert np.linalg.matrix_rank(functions) == 10
    polynomial = 3.0 - x[:, 0] + 2.0 * x[:, 1] * x[:, 2] - 4.0 * x[:, 0] ** 2 + x[:, 0] * x[:, 1]
    residual = np.linalg.lstsq(functions, polynomial, rcond=None)[1]
    assert residual[0] < 1e-20


def test_functions_that_the_mesh_cannot_tell_apart_are_dropped(small_tongue, domains):
    """Two domains with the same weight span no more than one."""
    seeds, weights, _ = domains
    B = blended_quadratic_basis(small_tongue, seeds[:2], weights[:, [0, 0]])
    assert B.shape[1] == 10


def test_a_mesh_without_enough_independent_functions_is_refused(small_tongue, domains):
    few = np.zeros((small_tongue.mesh.node_count, 5))
    few[-1] = 0.2
    with pytest.raises(LingualError, match="too coarse for 5 domains"):
        blended_quadratic_basis(small_tongue, domains[0], few)
