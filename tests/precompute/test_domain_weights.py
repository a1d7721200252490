"""Domain weights: a partition of unity together with the ground, greatest near their own seed."""

import numpy as np
import pytest

from lingual.model.discretisation import Discretisation
from lingual.precompute.domain_weights import blend_with_ground, diffuse, domain_weights, principal_direction
from lingual.precompute.seeds import choose_seeds


@pytest.fixture(scope="module")
def seeds(small_tongue):
    return choose_seeds(small_tongue, 7)


@pytest.fixture(scope="module")
def weights(small_tongue, seeds):
    return domain_weights(small_tongue, seeds)


def test_weights_lie_between_zero_and_one(weights):
    assert weights.min() >= 0.0
    assert 0.3 < weights.max() <= 1.0


def test_weights_vanish_on_held_nodes_and_sum_to_one_at_most(small_tongue, weights):
    assert not weights[small_tongue.fixed_nodes].any()
    assert weights.sum(axis=1).max() <= 1.0 + 1e-12
    assert weights.sum(axis=1)[small_tongue.free_nodes].min() > 0.0


def test_every_weight_is_greater_near_its_own_seed_than_at_the_others(seeds, weights):
    at_seeds = np.array([weights[s.nodes].mean(axis=0) for s in seeds])  # [seed, domain]
    np.testing.assert_array_equal(at_seeds.argmax(axis=0), np.arange(7))


def test_on_the_surface_the_greatest_value_lies_within_one_element_of_the_seed(small_tongue, seeds, weights):
    """The domain of the mass centre is a broad one without a peak."""
    tops = small_tongue.mesh.nodes[weights.argmax(axis=0)]
    distance = np.linalg.norm(tops - [s.centre for s in seeds], axis=1)
    assert np.delete(distance, 4).max() < 0.0075


def test_the_principal_direction_is_the_one_in_which_a_force_moves_the_body_most(small_tongue, seeds):
    free = small_tongue.free_nodes
    discretisation = Discretisation(small_tongue.mesh, small_tongue.material)
    discretisation.set_displacement(np.zeros_like(small_tongue.mesh.nodes))
    K = discretisation.stiffness().tocsr()
    direction = principal_direction(K, seeds[0].nodes, small_tongue.fixed_nodes)
    assert np.linalg.norm(direction) == pytest.approx(1.0)
    dofs = (3 * free[:, None] + np.arange(3)).ravel()
    compliance = np.linalg.inv(K[dofs][:, dofs].toarray())
    on_seed = np.isin(free, seeds[0].nodes) / len(seeds[0].nodes)

    def moved(force: np.ndarray) -> float:
        return float(np.linalg.norm(compliance @ np.outer(on_seed, force).ravel()))

    others = np.random.default_rng(16).standard_normal((200, 3))
    others /= np.linalg.norm(others, axis=1)[:, None]
    assert moved(direction) >= max(map(moved, others))


def test_blending_clips_holds_the_ground_and_divides_sums_above_one():
    raw = np.array([[-0.2, 0.5], [1.4, 1.0], [0.3, 0.4], [0.9, 0.8]])
    blended = blend_with_ground(raw, np.array([3]))
    np.testing.assert_allclose(blended, [[0.0, 0.5], [0.5, 0.5], [0.3, 0.4], [0.0, 0.0]])


@pytest.fixture(scope="module")
def rough(small_tongue):
    rng = np.random.default_rng(9)
    return blend_with_ground(rng.uniform(0.0, 1.0, (small_tongue.mesh.node_count, 3)), small_tongue.fixed_nodes)


def test_diffusion_smooths_without_leaving_the_interval_or_the_partition(small_tongue, rough):
    smooth, smoother = (diffuse(small_tongue, rough, length) for length in (0.003, 0.006))
    for weights in (smooth, smoother):
        assert weights.min() >= 0.0
        assert weights.sum(axis=1).max() <= 1.0 + 1e-12
        assert not weights[small_tongue.fixed_nodes].any()
    assert smoother.std() < smooth.std() < rough.std()


def test_diffusion_over_no_length_changes_nothing(small_tongue, rough):
    np.testing.assert_allclose(diffuse(small_tongue, rough, 0.0), rough, atol=1e-12)
