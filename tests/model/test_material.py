"""Lame parameters and the physical range of the constitutive parameters."""

from dataclasses import replace

import pytest

from lingual.model import LingualError, Material


def test_lame_parameters_give_back_young_and_poisson():
    material = Material(young_modulus=5000.0, poisson_ratio=0.3)
    mu, lam = material.lame_mu, material.lame_lambda
    assert mu * (3 * lam + 2 * mu) / (lam + mu) == pytest.approx(5000.0)
    assert lam / (2 * (lam + mu)) == pytest.approx(0.3)


def test_defaults_are_those_of_luo():
    m = Material()
    assert (m.young_modulus, m.poisson_ratio, m.density) == (6912.0, 0.49, 1000.0)
    assert (m.damping_mass, m.damping_stiffness) == (6.22, 0.11)


@pytest.mark.parametrize(
    "wrong",
    [
        {"young_modulus": 0.0},
        {"young_modulus": float("nan")},
        {"poisson_ratio": 0.5},
        {"poisson_ratio": -1.0},
        {"mooney_rivlin": (0.0, 0.0, 0.0, 486.0, 0.0)},
        {"mooney_rivlin": (1037.0, 486.0)},
        {"bulk_modulus": 0.0},
        {"density": -1.0},
        {"damping_mass": -0.1},
        {"damping_stiffness": -0.1},
    ],
)
def test_a_value_outside_its_range_is_refused(wrong):
    with pytest.raises(LingualError):
        Material(**wrong)


def test_a_law_that_there_is_not_is_refused_with_those_that_there_are():
    with pytest.raises(LingualError, match="'jelly'; choose one of stvk, neo-hookean, corotational, mooney-rivlin"):
        replace(Material(), model="jelly")


def test_mooney_rivlin_by_its_name_is_the_published_tongue():
    """C10 = 1037 Pa and C20 = 486 Pa (Buchaillard et al. 2009): E = 6.2 kPa and nu = 0.49 at small strain."""
    material = replace(Material(), model="mooney-rivlin")
    mu, lam = material.lame_mu, material.lame_lambda
    assert mu == 2.0 * 1037.0
    assert lam + 2.0 / 3.0 * mu == pytest.approx(100.0 * 1037.0)
    assert lam / (2.0 * (lam + mu)) == pytest.approx(0.49, abs=1e-3)
    assert material.elastic_parameters == [1037.0, 0.0, 0.0, 486.0, 0.0, 103700.0]


@pytest.mark.parametrize("model", ["stvk", "neo-hookean", "corotational", "mooney-rivlin"])
def test_damping_is_that_of_the_small_strain_moduli_of_every_law(model):
    material = Material(model)
    assert material.viscous_parameters == [material.lame_mu, material.lame_lambda, 0.0, 0.0, 0.0, 0.0]
