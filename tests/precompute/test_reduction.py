"""From a tongue to its reduced model, cached; and on the measured mesh when it is there."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from lingual.model import LingualError, Material
from lingual.precompute.domain_weights import WEIGHTINGS
from lingual.precompute.meshes.library import load_tongue
from lingual.precompute.reduction import ReductionSettings, all_element_model, build_reduced_model

SMALL = ReductionSettings(pose_count=12, cubature_per_domain=12)


@pytest.fixture
def build(cache_folder, small_tongue, monkeypatch):
    """Function (tongue, settings) -> reduced model and the stages that ran for it, the held-out poses few."""
    monkeypatch.setattr("lingual.precompute.reduction.HELD_OUT_POSES", 4)

    def run(tongue=small_tongue, settings=SMALL):
        stages = []
        model = build_reduced_model(tongue, settings, progress=lambda stage, fraction: stages.append((stage, fraction)))
        return model, stages

    return run


def test_the_model_is_complete_and_names_its_domains(build, small_tongue):
    model, _ = build()
    assert model.domain_names == ("TT", "TB", "TD", "TR", "centre")
    assert (model.domain_count, model.column_count, model.dof_count) == (5, 50, 150)
    assert model.domain_weights.shape == (small_tongue.mesh.node_count, 5)
    assert len(model.cubature_elements) <= 60
    assert 0.0 < model.cubature_error < 0.5
    assert model.gradient_operator.shape == (3 * len(model.cubature_elements), 50)
    assert model.sensor_rows.shape == (4, 50)


def test_progress_of_every_stage_runs_from_none_to_all(build):
    _, stages = build()
    for stage in ("domain weights", "training poses", "cubature training forces", "cubature elements"):
        fractions = [f for s, f in stages if s == stage]
        assert fractions[0] == 0.0
        assert fractions[-1] == 1.0
        assert np.all(np.diff(fractions) >= 0.0) or stage == "cubature elements"


def test_a_second_build_is_read_from_the_cache_and_equal(build):
    first, _ = build()
    second, stages = build()
    assert stages == []
    for name in ("seeds", "domain_weights", "basis", "cubature_elements", "cubature_weights"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
    assert (second.domain_names, second.cubature_error) == (first.domain_names, first.cubature_error)


@pytest.mark.parametrize(
    "change",
    [
        lambda tongue: replace(tongue, fixed_nodes=np.append(tongue.fixed_nodes, 30)),
        lambda tongue: replace(tongue, material=Material(poisson_ratio=0.4)),
        lambda tongue: replace(tongue, sensors=replace(tongue.sensors, weights=tongue.sensors.weights[[0, 1, 3, 2]])),
    ],
    ids=["attachment", "material", "sensors"],
)
def test_another_tongue_is_built_anew(build, small_tongue, change):
    build()
    _, stages = build(change(small_tongue))
    assert stages


def test_other_settings_are_built_anew(build):
    build()
    assert build(settings=replace(SMALL, domain_count=6))[0].domain_count == 6
    assert build(settings=replace(SMALL, seed=1))[1]
    assert build(settings=replace(SMALL, ground_blending=False))[1]


def test_the_weighting_can_be_chosen_and_each_has_its_own_cached_model(build):
    models = [build(settings=replace(SMALL, weighting=weighting))[0] for weighting in WEIGHTINGS]
    for one, other in combinations(models, 2):
        assert np.abs(one.domain_weights - other.domain_weights).max() > 0.02


def test_cubature_and_poses_grow_more_slowly_than_many_domains():
    few, five, many = (ReductionSettings(domain_count=n) for n in (4, 5, 20))
    assert (few.cubature_limit, five.cubature_limit, many.cubature_limit) == (800, 1000, 2000)
    assert (few.training_poses, five.training_poses, many.training_poses) == (120, 120, 60)


def test_too_few_domains_are_refused_before_any_work(build):
    with pytest.raises(LingualError, match="3 domains are too few"):
        build(settings=replace(SMALL, domain_count=3))


def test_all_element_weights_are_the_volumes(small_tongue):
    model = all_element_model(small_tongue, 5)
    np.testing.assert_array_equal(model.cubature_weights, small_tongue.mesh.volumes)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_on_the_measured_mesh_the_reduced_force_is_within_five_per_cent(shared_data, record_property):
    """Held-out poses, root mean square; the author's own set had 269 elements."""
    tongue = load_tongue(shared_data / "luo_tongue")
    model = build_reduced_model(tongue)
    record_property("cubature_error", model.cubature_error)
    record_property("cubature_elements", len(model.cubature_elements))
    assert model.dof_count == 150
    assert model.cubature_error < 0.05
    assert model.cubature_weights.min() > 0.0
    assert len(model.cubature_elements) <= 1000
    gram = model.basis.T @ (tongue.node_masses[:, None] * model.basis)
    np.testing.assert_allclose(gram, np.eye(50), rtol=0, atol=1e-10)
    assert not model.domain_weights[tongue.fixed_nodes].any()
    assert model.domain_weights.sum(axis=1).max() <= 1.0 + 1e-12
