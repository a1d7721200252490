"""Lame parameters and the physical range of the constitutive parameters."""

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
        {"density": -1.0},
        {"damping_mass": -0.1},
        {"damping_stiffness": -0.1},
    ],
)
def test_a_value_outside_its_range_is_refused(wrong):
    with pytest.raises(LingualError):
        Material(**wrong)
