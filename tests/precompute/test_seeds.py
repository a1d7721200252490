"""Seeds: at the sensors, at the mass centre, then far apart."""

import numpy as np
import pytest

from lingual.model import LingualError
from lingual.precompute.seeds import choose_seeds


def test_the_first_seeds_are_the_sensors_and_the_mass_centre(small_tongue):
    seeds = choose_seeds(small_tongue, 5)
    assert [s.name for s in seeds] == ["TT", "TB", "TD", "TR", "centre"]
    for seed, sensor in zip(seeds, small_tongue.sensor_rest_positions, strict=False):
        assert np.linalg.norm(seed.centre - sensor) < 6e-3
    assert np.linalg.norm(seeds[4].centre - [0.03, 0.015, 0.01]) < 6e-3


def test_as_many_domains_as_sensors_leave_out_the_mass_centre(small_tongue):
    assert [s.name for s in choose_seeds(small_tongue, 4)] == ["TT", "TB", "TD", "TR"]


def test_a_footprint_of_no_radius_is_the_nearest_node(small_tongue):
    for seed, sensor in zip(choose_seeds(small_tongue, 4, 0.0), small_tongue.sensor_rest_positions, strict=True):
        np.testing.assert_allclose(small_tongue.mesh.nodes[seed.nodes], [sensor])


def test_further_seeds_are_far_from_the_others_and_from_the_ground(small_tongue):
    seeds = choose_seeds(small_tongue, 9)
    centres = np.array([s.centre for s in seeds])
    gaps = np.linalg.norm(centres[:, None] - centres[None], axis=2)[np.triu_indices(9, 1)]
    assert gaps[-1] > 5e-3
    assert centres[5:, 0].min() > 0.01


def test_footprints_are_free_nodes_that_share_none(small_tongue):
    footprints = [s.nodes for s in choose_seeds(small_tongue, 9)]
    together = np.concatenate(footprints)
    assert len(np.unique(together)) == len(together)
    assert not np.isin(together, small_tongue.fixed_nodes).any()
    assert min(map(len, footprints)) >= 1


@pytest.mark.parametrize(("count", "sentence"), [(3, "sensors need 4; ask for more"), (150, "no room for 150 domains")])
def test_a_count_that_does_not_fit_is_refused(small_tongue, count, sentence):
    with pytest.raises(LingualError, match=sentence):
        choose_seeds(small_tongue, count)
