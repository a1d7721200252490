"""The constitutive triple: energy, its gradient and its Hessian, as the elasticity kernels evaluate it."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from lingual.kernels.materials import MATERIALS, material_triple, pack_parameters

SHEAR = np.array([[1.1, 0.3, -0.2], [0.1, 0.9, 0.25], [-0.15, 0.05, 1.2]])
TURN = Rotation.from_rotvec([1.2, -2.0, 0.7]).as_matrix()

DEFORMATIONS = {
    "rest": np.eye(3),
    "shear and stretch": SHEAR,
    "turned by 140 degrees": TURN @ SHEAR,
    "compressed to a tenth": np.diag([0.1, 0.6, 0.9]) @ SHEAR,
    "flattened": np.diag([0.0, 1.1, 1.2]),
    "inverted": np.diag([-0.7, 1.2, 0.9]) @ SHEAR,
}

matrices = arrays(np.float64, (3, 3), elements=st.floats(-2.0, 2.0))
rotations = (
    arrays(np.float64, 4, elements=st.floats(-1.0, 1.0))
    .filter(lambda q: np.linalg.norm(q) > 0.1)
    .map(lambda q: Rotation.from_quat(q).as_matrix())
)


@pytest.fixture(params=DEFORMATIONS.values(), ids=DEFORMATIONS.keys())
def F(request) -> np.ndarray:
    return request.param


def central_difference(function, F: np.ndarray, step: float = 1e-5) -> np.ndarray:
    """Derivative of function((n, 3, 3)) -> (n, ...) at F, with the two axes of F last."""
    directions = np.eye(9).reshape(9, 3, 3)
    difference = function(F + step * directions) - function(F - step * directions)
    return np.moveaxis(difference / (2.0 * step), 0, -1).reshape(*difference.shape[1:], 3, 3)


def test_rest_is_free_of_energy_and_stress(elasticity):
    rest = np.eye(3)[None]
    energy, det_f = elasticity.energy(rest)
    assert energy[0] == 0.0
    assert det_f[0] == 1.0
    assert not elasticity.stress(rest).any()


def test_at_rest_the_tangent_is_isotropic_linear_elasticity(elasticity, close):
    mu, lam, delta = elasticity.mu, elasticity.lam, np.eye(3)
    hooke = lam * np.einsum("ij,mn->ijmn", delta, delta)
    hooke += mu * (np.einsum("im,jn->ijmn", delta, delta) + np.einsum("in,jm->ijmn", delta, delta))
    close(elasticity.tangent(np.eye(3)[None])[0], hooke)


def test_stress_is_the_gradient_of_the_energy(exact_elasticity, F):
    numeric = central_difference(lambda x: exact_elasticity.energy(x)[0], F)
    stress = exact_elasticity.stress(F[None])[0]
    np.testing.assert_allclose(stress, numeric, rtol=0, atol=1e-8 * exact_elasticity.lam)


def test_tangent_is_the_gradient_of_the_stress_and_symmetric(exact_elasticity, F):
    numeric = central_difference(exact_elasticity.stress, F)
    tangent = exact_elasticity.tangent(F[None])[0]
    np.testing.assert_allclose(tangent, numeric, rtol=0, atol=1e-8 * exact_elasticity.lam)
    np.testing.assert_allclose(tangent, tangent.transpose(2, 3, 0, 1), rtol=0, atol=1e-14 * abs(tangent).max())


@settings(max_examples=40)
@given(F=matrices, R=rotations, Q=rotations)
def test_turning_the_body_turns_the_stress_and_keeps_the_energy(exact_elasticity, F, R, Q):
    """Objective (P(RF) = R P(F)) and isotropic (P(FQ) = P(F) Q)."""
    turned = np.stack([F, R @ F, F @ Q])
    energy, _ = exact_elasticity.energy(turned)
    stress = exact_elasticity.stress(turned)
    tolerance = 1e-11 * exact_elasticity.lam * (1.0 + np.linalg.norm(F)) ** 4
    np.testing.assert_allclose(energy, energy[0], rtol=0, atol=tolerance)
    np.testing.assert_allclose(stress[1], R @ stress[0], rtol=0, atol=tolerance)
    np.testing.assert_allclose(stress[2], stress[0] @ Q, rtol=0, atol=tolerance)


@settings(max_examples=40)
@given(F=matrices)
def test_the_energy_is_never_negative_even_for_inverted_elements(exact_elasticity, F):
    assert exact_elasticity.energy(F[None])[0][0] >= 0.0


def test_parameters_are_packed_in_the_documented_order():
    assert list(pack_parameters("stvk", 2.0, 3.0)) == [2.0, 3.0, 0.0, 0.0, 0.0, 0.0]


@pytest.mark.parametrize("make", [lambda: pack_parameters("jelly", 1, 1), lambda: material_triple("jelly", "float64")])
def test_an_unknown_material_is_a_key_error(make):
    assert "jelly" not in MATERIALS
    with pytest.raises(KeyError):
        make()
