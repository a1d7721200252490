"""The study of domain weights: its figures, and the ranking that the paper shows."""

import numpy as np
import pytest

from lingual.analysis.cantilever import load_end_cantilever
from lingual.analysis.weight_study import TREATMENTS, study_weights, tongue_bend
from lingual.precompute.domain_weights import WEIGHTINGS


@pytest.fixture(scope="module")
def study():
    """The load-end cantilever on a coarser grid; finer ones rank the same (docs/design/domain_weights.md)."""
    return study_weights(load_end_cantilever((18, 4, 2)), 3, 0.0)


def test_every_weighting_is_tried_with_every_treatment_and_converges(study):
    assert [(t.weighting, t.treatment) for t in study.trials] == [(w, t) for w in WEIGHTINGS for t in TREATMENTS]
    assert study.full.converged
    assert all(trial.equilibrium.converged for trial in study.trials)


def test_a_subspace_is_stiffer_than_the_full_space(study):
    tip = study.bend.tip_displacement(study.full.displacement)[2]
    for trial in study.trials:
        assert trial.energy_error > 0.0
        assert tip < study.bend.tip_displacement(trial.equilibrium.displacement)[2] < 0.0


def test_errors_are_relative_to_the_full_bend(study):
    trial = study.trial("harmonic", "raw")
    masses = study.bend.tongue.node_masses
    gap = np.linalg.norm(trial.equilibrium.displacement - study.full.displacement, axis=1)
    whole = np.linalg.norm(study.full.displacement, axis=1)
    assert trial.displacement_error == pytest.approx(np.sqrt(masses @ gap**2 / (masses @ whole**2)))


def test_raw_weights_rank_as_in_the_paper(study):
    """Luo (2017), Fig. 7: principal bends most naturally; fixed is over-damped; the rivals trail far behind."""
    error = {w: study.trial(w, "raw").displacement_error for w in WEIGHTINGS}
    assert error["principal"] < 0.7 * error["fixed"]
    assert error["fixed"] < error["harmonic"] < error["perpendicular"]
    assert error["principal"] < 0.07


def test_the_principal_weights_stay_best_when_treated_as_a_simulation_does(study):
    for treatment in TREATMENTS:
        error = {w: study.trial(w, treatment).displacement_error for w in WEIGHTINGS}
        assert min(error, key=error.get) == "principal"


def test_diffusion_makes_up_for_the_kinks_of_blending(study):
    for weighting in WEIGHTINGS:
        blended, diffused = (study.trial(weighting, t).displacement_error for t in ("blended", "diffused"))
        assert diffused < 0.8 * blended


def test_the_partition_cuts_the_cantilever_across(study):
    """Seeds at 1/3, 2/3 and the end: domains change in the middle between them."""
    x = study.bend.tongue.mesh.nodes[:, 0] / 0.09
    for domain, (low, high) in enumerate([(0.0, 0.5), (0.5, 5 / 6), (5 / 6, 1.0)]):
        inside = x[study.partition == domain]
        assert low - 0.08 < inside.min()
        assert inside.max() < high + 0.08


def test_a_tongue_is_bent_by_lifting_its_tip(small_tongue):
    bend = tongue_bend(small_tongue)
    loaded = np.flatnonzero(bend.load.any(axis=1))
    foremost = small_tongue.sensor_rest_positions[0]
    assert np.linalg.norm(small_tongue.mesh.nodes[loaded] - foremost, axis=1).max() < 8e-3
    assert (bend.load[loaded, 2] > 0.0).all()
    assert not np.isin(loaded, small_tongue.fixed_nodes).any()
    study = study_weights(bend, 5)
    assert study.full.converged
    assert 0.003 < study.bend.tip_displacement(study.full.displacement)[2] < 0.02
    assert all(0.0 < trial.energy_error < 1.0 for trial in study.trials)
