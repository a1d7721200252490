"""The reduced solver approaches the full one as its subspace grows."""

import numpy as np
import pytest

from lingual.precompute.reduction import all_element_model
from lingual.solver.full_space import SolverFullSpace
from lingual.solver.reduced import SolverReduced

POSTURE = {("TT", 0): -0.002, ("TT", 2): 0.006, ("TB", 2): 0.004, ("TD", 0): -0.002, ("TR", 2): 0.002}


@pytest.fixture(scope="module")
def distances(block, tongue_of, small_tongue, control_of, static):
    """Mean distance of the two surfaces [mm] in a static posture, by number of domains."""
    control = control_of(small_tongue, POSTURE)
    skin = small_tongue.skin
    full = skin.vertices(static(SolverFullSpace(small_tongue), control, 2).position.numpy())

    def distance(domains: int) -> float:
        solver = SolverReduced(all_element_model(small_tongue, domains))
        reduced = skin.vertices(static(solver, control, 2).position.numpy())
        return 1e3 * float(np.linalg.norm(reduced - full, axis=1).mean())

    return {domains: distance(domains) for domains in (5, 8, 12)}


def test_the_surface_distance_falls_as_domains_are_added(distances):
    assert distances[5] > distances[8] > distances[12]
    assert distances[12] < 0.6 * distances[5]


def test_five_domains_are_within_half_a_millimetre(distances):
    assert distances[5] < 0.5
