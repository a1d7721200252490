"""Domain weights: a partition of unity together with the ground, greatest near their own seed;
and the four ways to find them."""

from functools import cache
from itertools import combinations

import numpy as np
import pytest

from lingual.model import LingualError
from lingual.precompute.domain_weights import (
    WEIGHTINGS,
    blend_with_ground,
    diffuse,
    domain_weights,
    harmonic_weights,
    raw_weights,
    treated,
)
from lingual.precompute.seeds import Seed, choose_seeds


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


@pytest.fixture(scope="module")
def raw_of(small_tongue, seeds):
    """Function weighting -> raw weights (node_count, 7)."""
    return cache(lambda weighting: raw_weights(small_tongue, seeds, weighting))


@pytest.mark.parametrize("weighting", WEIGHTINGS)
def test_raw_weights_are_one_on_their_seed_and_zero_on_the_others_and_the_ground(
    raw_of, small_tongue, seeds, weighting
):
    raw = raw_of(weighting)
    at_seeds = np.array([raw[s.nodes].mean(axis=0) for s in seeds])
    np.testing.assert_allclose(at_seeds, np.eye(7), atol=1e-12)
    np.testing.assert_allclose(raw[small_tongue.fixed_nodes], 0.0, atol=1e-12)


def test_the_four_weightings_differ(raw_of):
    for one, other in combinations(WEIGHTINGS, 2):
        assert np.abs(raw_of(one) - raw_of(other)).max() > 0.05


@pytest.mark.parametrize("weighting", WEIGHTINGS)
def test_every_weighting_when_treated_is_a_partition_of_unity_with_the_ground(raw_of, small_tongue, weighting):
    for length in (0.0, 0.003):
        weights = treated(small_tongue, raw_of(weighting), True, length)
        assert 0.0 <= weights.min() <= weights.max() <= 1.0
        assert weights.sum(axis=1).max() <= 1.0 + 1e-12
        assert not weights[small_tongue.fixed_nodes].any()


def test_without_treatment_raw_weights_stay_as_they_are(raw_of, small_tongue, seeds):
    np.testing.assert_array_equal(domain_weights(small_tongue, seeds, "fixed", False, 0.0), raw_of("fixed"))


def test_harmonic_weights_obey_the_maximum_principle(raw_of, small_tongue, seeds):
    """They lie between the values they are held at, which are reached nowhere else, and average their neighbours."""
    raw = raw_of("harmonic")
    held = np.concatenate([small_tongue.fixed_nodes, *(s.nodes for s in seeds)])
    inside = np.delete(raw, held, axis=0)
    assert inside.min() > 0.0
    assert inside.max() < 1.0
    assert inside.sum(axis=1).max() < 1.0


def test_harmonic_weights_are_linear_along_a_bar_between_its_ends(block, tongue_of):
    mesh = block((0.05, 0.01, 0.01), (10, 2, 2))
    bar = tongue_of(mesh, {"TT": mesh.node_count - 1})
    middle, end = (np.flatnonzero(np.isclose(mesh.nodes[:, 0], x)) for x in (0.03, 0.05))
    seeds = [Seed(name, nodes, mesh.nodes[nodes].mean(axis=0)) for name, nodes in (("middle", middle), ("end", end))]
    x = mesh.nodes[:, 0]
    expected = np.stack([np.interp(x, [0.0, 0.03, 0.05], w) for w in ([0.0, 1.0, 0.0], [0.0, 0.0, 1.0])], axis=1)
    np.testing.assert_allclose(harmonic_weights(bar, seeds), expected, atol=1e-10)


def test_a_weighting_that_there_is_not_is_refused(small_tongue, seeds):
    with pytest.raises(LingualError, match="no weighting 'magic'; choose one of principal, fixed"):
        raw_weights(small_tongue, seeds, "magic")


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
        assert weights.min() > -1e-12
        assert weights.sum(axis=1).max() <= 1.0 + 1e-12
        assert not weights[small_tongue.fixed_nodes].any()
    assert smoother.std() < smooth.std() < rough.std()


def test_diffusion_over_no_length_changes_nothing(small_tongue, rough):
    np.testing.assert_allclose(diffuse(small_tongue, rough, 0.0), rough, atol=1e-12)
