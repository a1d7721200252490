"""Every constitutive law: energy, its gradient and its Hessian, as the elasticity kernels evaluate them."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from lingual.kernels.materials import MATERIALS, material_triple, pack_parameters
from lingual.kernels.precision import precision

DOUBLE, SINGLE = precision("float64"), precision("float32")

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
DEGENERATE = {
    "point": np.zeros((3, 3)),
    "line": np.outer([1.0, 2.0, -1.0], [0.3, 0.0, 0.4]),
    "plane": np.diag([1.0, 1.0, 0.0]),
    "mirrored": np.diag([1.0, 1.0, -1.0]),
    "mirrored in the middle": np.diag([1.0, -1.0, 1.0]),
    "turned inside out": -np.eye(3),
    "almost flat": TURN @ np.diag([1.2, 0.8, 1e-9]),
    "a hair": np.diag([2.0, 1e-6, -1e-6]) @ TURN,
}

matrices = arrays(np.float64, (3, 3), elements=st.floats(-2.0, 2.0))
rotations = (
    arrays(np.float64, 4, elements=st.floats(-1.0, 1.0))
    .filter(lambda q: np.linalg.norm(q) > 0.1)
    .map(lambda q: Rotation.from_quat(q).as_matrix())
)


@pytest.fixture(scope="session", params=sorted(MATERIALS))
def model(request) -> str:
    return request.param


@pytest.fixture(scope="session")
def law(types, elasticity_of, model):
    """In both precisions."""
    return elasticity_of(types, model)


@pytest.fixture(scope="session")
def exact_law(elasticity_of, model):
    """In double precision."""
    return elasticity_of(DOUBLE, model)


@pytest.fixture(params=DEFORMATIONS.values(), ids=DEFORMATIONS.keys())
def F(request) -> np.ndarray:
    return request.param


def central_difference(function, F: np.ndarray, step: float = 1e-5) -> np.ndarray:
    """Derivative of function((n, 3, 3)) -> (n, ...) at F, with the two axes of F last."""
    directions = np.eye(9).reshape(9, 3, 3)
    difference = function(F + step * directions) - function(F - step * directions)
    return np.moveaxis(difference / (2.0 * step), 0, -1).reshape(*difference.shape[1:], 3, 3)


def signed_stretches(F: np.ndarray) -> np.ndarray:
    """Singular values, the smallest negative for a reflection."""
    s = np.linalg.svd(F, compute_uv=False)
    return s * [1.0, 1.0, np.sign(np.linalg.det(F))]


def hooke(law) -> np.ndarray:
    """Isotropic linear elasticity with the law's Lame parameters, (3, 3, 3, 3)."""
    delta = np.eye(3)
    return law.lam * np.einsum("ij,mn->ijmn", delta, delta) + law.mu * (
        np.einsum("im,jn->ijmn", delta, delta) + np.einsum("in,jm->ijmn", delta, delta)
    )


def as_matrix(tangent: np.ndarray) -> np.ndarray:
    return tangent.reshape(*tangent.shape[:-4], 9, 9)


# --- Energies written a second time, from the literature, for F with det F > 0.2 -----------------------------


def stvk_energy(law, F):
    E = 0.5 * (F.T @ F - np.eye(3))
    return law.mu * np.sum(E * E) + 0.5 * law.lam * np.trace(E) ** 2


def neo_hookean_energy(law, F):
    """The final energy of Smith et al. 2018, less its value at rest."""
    mu, lam = 4.0 / 3.0 * law.mu, law.lam + 5.0 / 6.0 * law.mu

    def energy(F):
        I_C, alpha = np.sum(F * F), 1.0 + 0.75 * mu / lam
        return 0.5 * mu * (I_C - 3.0 - np.log(I_C + 1.0)) + 0.5 * lam * (np.linalg.det(F) - alpha) ** 2

    return energy(F) - energy(np.eye(3))


def corotational_energy(law, F):
    s = signed_stretches(F)
    return law.mu * np.sum((s - 1.0) ** 2) + 0.5 * law.lam * np.sum(s - 1.0) ** 2


def mooney_rivlin_energy(law, F):
    c10, c01, c11, c20, c02 = law.material.mooney_rivlin
    C, J = F.T @ F, np.linalg.det(F)
    I1 = np.trace(C)
    I2 = 0.5 * (I1**2 - np.trace(C @ C))
    i, j = J ** (-2.0 / 3.0) * I1 - 3.0, J ** (-4.0 / 3.0) * I2 - 3.0
    bulk = 0.5 * law.material.bulk_modulus * (J - 1.0) ** 2
    return c10 * i + c01 * j + c11 * i * j + c20 * i**2 + c02 * j**2 + bulk


ENERGIES = {
    "stvk": stvk_energy,
    "neo-hookean": neo_hookean_energy,
    "corotational": corotational_energy,
    "mooney-rivlin": mooney_rivlin_energy,
}
REGULAR = [F for name, F in DEFORMATIONS.items() if np.linalg.det(F) > 0.2 and name != "rest"]


def test_the_energy_is_the_literature_s(law, model, close):
    F = np.array(REGULAR)
    energy, det_f = law.energy(F)
    close(energy, np.array([ENERGIES[model](law, each) for each in F]))
    close(det_f, np.linalg.det(F))


@pytest.mark.parametrize("constant", range(5), ids=["C10", "C01", "C11", "C20", "C02"])
def test_each_mooney_rivlin_constant_acts_on_its_invariant(elasticity_of, constant):
    constants = 800.0 * np.eye(5)[constant] + [300.0, 0.0, 0.0, 0.0, 0.0]
    law = elasticity_of(DOUBLE, "mooney-rivlin", mooney_rivlin=tuple(constants))
    for F in REGULAR:
        assert law.energy(F[None])[0][0] == pytest.approx(mooney_rivlin_energy(law, F), rel=1e-12)
    for F in DEFORMATIONS.values():
        stress, tangent = law.stress(F[None])[0], law.tangent(F[None])[0]
        numeric_stress = central_difference(lambda x: law.energy(x)[0], F)
        numeric_tangent = central_difference(law.stress, F)
        np.testing.assert_allclose(stress, numeric_stress, rtol=0, atol=1e-6 * (abs(stress).max() + law.mu))
        np.testing.assert_allclose(tangent, numeric_tangent, rtol=0, atol=1e-6 * abs(tangent).max())


# --- What every law owes ---------------------------------------------------------------------------------------


def test_rest_is_free_of_energy_and_stress(law):
    rest = np.eye(3)[None]
    energy, det_f = law.energy(rest)
    assert energy[0] == 0.0
    assert det_f[0] == 1.0
    assert not law.stress(rest).any()


def test_at_rest_the_tangent_is_isotropic_linear_elasticity(law, close):
    close(law.tangent(np.eye(3)[None])[0], hooke(law))


def test_small_strains_are_linear_elastic_in_any_orientation(exact_law):
    """P = Q (2 mu e + lambda tr(e) I) + O(e^2): a tenth of the strain leaves a hundredth of the difference."""
    shape = SHEAR + SHEAR.T - 2.0 * np.eye(3)

    def difference(size: float) -> float:
        strain = size * shape
        stress = exact_law.stress((TURN @ (np.eye(3) + strain))[None])[0]
        linear = TURN @ np.einsum("ijmn,mn->ij", hooke(exact_law), strain)
        return float(np.linalg.norm(stress - linear) / np.linalg.norm(linear))

    assert difference(1e-4) < 1e-2
    assert difference(1e-5) < 0.11 * difference(1e-4) + 1e-10


def test_stress_is_the_gradient_of_the_energy(exact_law, F):
    numeric = central_difference(lambda x: exact_law.energy(x)[0], F)
    stress = exact_law.stress(F[None])[0]
    np.testing.assert_allclose(stress, numeric, rtol=0, atol=1e-8 * (exact_law.lam + abs(stress).max()))


def test_tangent_is_the_gradient_of_the_stress_and_symmetric(exact_law, F):
    numeric = central_difference(exact_law.stress, F)
    tangent = exact_law.tangent(F[None])[0]
    np.testing.assert_allclose(tangent, numeric, rtol=0, atol=1e-7 * abs(tangent).max())
    np.testing.assert_allclose(tangent, tangent.transpose(2, 3, 0, 1), rtol=0, atol=1e-13 * abs(tangent).max())


@settings(max_examples=40)
@given(F=matrices, R=rotations, Q=rotations)
def test_turning_the_body_turns_the_stress_and_keeps_the_energy(exact_law, F, R, Q):
    """Objective (P(RF) = R P(F)) and isotropic (P(FQ) = P(F) Q)."""
    if exact_law.material.model == "corotational":  # its stress jumps where two stretches cancel
        s = signed_stretches(F)
        assume(s[1] + s[2] > 1e-2)
    turned = np.stack([F, R @ F, F @ Q])
    energy, _ = exact_law.energy(turned)
    stress = exact_law.stress(turned)
    tolerance = 1e-11 * exact_law.lam * (1.0 + np.linalg.norm(F)) ** 4
    np.testing.assert_allclose(energy, energy[0], rtol=0, atol=tolerance)
    np.testing.assert_allclose(stress[1], R @ stress[0], rtol=0, atol=tolerance)
    np.testing.assert_allclose(stress[2], stress[0] @ Q, rtol=0, atol=tolerance)


@settings(max_examples=60)
@given(F=matrices)
def test_the_energy_is_never_negative_even_for_inverted_elements(exact_law, F):
    assert exact_law.energy(F[None])[0][0] >= 0.0


def test_single_precision_keeps_the_stress_of_a_strain_of_a_thousandth(elasticity_of, model, exact_law):
    """F rounds to 6e-8, which lambda, fifty times mu, makes a hundredth of a pascal; nothing more is lost."""
    single = elasticity_of(SINGLE, model)
    F = np.eye(3) + 1e-3 * np.random.default_rng(5).standard_normal((50, 3, 3))
    error = np.linalg.norm(single.stress(F) - exact_law.stress(F), axis=(1, 2))
    assert error.max() < 2e-7 * exact_law.lam
    energy, expected = single.energy(F)[0], exact_law.energy(F)[0]
    assert abs(energy - expected).max() < 2e-3 * expected.max()


# --- Collapse and inversion --------------------------------------------------------------------------------------


@pytest.mark.parametrize("F", DEGENERATE.values(), ids=DEGENERATE.keys())
def test_collapse_and_inversion_are_finite_in_both_precisions(law, F):
    energy, _ = law.energy(F[None])
    assert np.isfinite(energy[0])
    assert energy[0] > 0.0 or F[0, 0] * F[1, 1] * F[2, 2] < 0.0  # stvk takes a mirror image for a body at rest
    assert np.isfinite(law.stress(F[None])).all()
    for definite in (False, True):
        assert np.isfinite(law.tangent(F[None], definite=definite)).all()


def pressed(law, stretches) -> np.ndarray:
    """P_33 [Pa] of an element held at the sides and pressed to each stretch along z."""
    F = np.tile(np.eye(3), (len(stretches), 1, 1))
    F[:, 2, 2] = stretches
    return law.stress(F)[:, 2, 2]


def test_a_pressed_element_pushes_back_until_it_is_inside_out(exact_law):
    """All but stvk, which gives way below 1 / sqrt(3) and pulls itself through to its mirror image."""
    stress = pressed(exact_law, np.linspace(-0.9, 0.99, 64))
    if exact_law.material.model == "stvk":
        stretches = np.linspace(0.01, 0.99, 197)
        assert stretches[np.argmin(pressed(exact_law, stretches))] == pytest.approx(3.0**-0.5, abs=0.01)
        assert pressed(exact_law, [-0.5])[0] > 0.0
    else:
        assert (stress < 0.0).all()


def test_mooney_rivlin_is_continued_below_a_fifth_of_the_volume_with_two_derivatives(elasticity_of):
    """On either side of det F = 0.2 energy, stress and tangent agree up to the distance."""
    law = elasticity_of(DOUBLE, "mooney-rivlin")
    below, above = (SHEAR * ((0.2 + side) / np.linalg.det(SHEAR)) ** (1 / 3) for side in (-1e-9, 1e-9))
    both = np.stack([below, above])
    for values in (law.energy(both)[0], law.stress(both), law.tangent(both)):
        np.testing.assert_allclose(values[0], values[1], rtol=0, atol=1e-7 * abs(values[1]).max())


# --- Projection ----------------------------------------------------------------------------------------------------


def drawn_and_crumpled() -> np.ndarray:
    """100 elements drawn out along one axis and a little swollen, in tension all round; 100 of any shape."""
    rng = np.random.default_rng(3)
    draw, swell = rng.uniform(1.02, 1.3, 100), rng.uniform(1.005, 1.03, 100)
    stretches = swell[:, None] * np.stack([draw, draw**-0.5, draw**-0.5], axis=1)
    turns = Rotation.random(100, rng).as_matrix()
    drawn = turns @ (stretches[:, :, None] * Rotation.random(100, rng).as_matrix())
    return np.concatenate([drawn, np.eye(3) + 0.35 * rng.standard_normal((100, 3, 3))])


RANDOM = drawn_and_crumpled()


def test_the_definite_tangent_is_the_exact_one_without_its_negative_eigenvalues(exact_law):
    """Against NumPy's eigenvalues of the whole 9 x 9 tangent; some elements are stretched, some inverted."""
    values, vectors = np.linalg.eigh(as_matrix(exact_law.tangent(RANDOM)))
    expected = np.einsum("eik,ek,ejk->eij", vectors, np.maximum(values, 0.0), vectors)
    projected = as_matrix(exact_law.tangent(RANDOM, definite=True))
    scale = abs(values).max(axis=1)[:, None, None]
    assert (values[:, 0] < -1e-3 * values[:, -1]).sum() > 10
    assert (values[:, 0] > 0.0).sum() > 20
    np.testing.assert_allclose(projected / scale, expected / scale, rtol=0, atol=1e-9)
    assert (np.linalg.eigvalsh(projected) / scale[:, 0] >= -1e-12).all()


def test_an_element_that_is_definite_keeps_its_tangent_to_the_last_digit(law):
    lowest = np.linalg.eigvalsh(as_matrix(law.tangent(RANDOM)).astype(np.float64))[:, 0]
    definite = RANDOM[lowest > 1e-4 * law.mu]
    assert len(definite) > 20
    exact = law.tangent(definite)
    rounding = 0.0 if law.device == "cpu" else 8.0 * np.finfo(exact.dtype).eps  # two kernels may contract differently
    np.testing.assert_allclose(law.tangent(definite, definite=True), exact, rtol=0, atol=rounding * abs(exact).max())


def test_projection_leaves_damping_and_weight_alone(exact_law):
    start, weight = SHEAR[None].repeat(200, axis=0), np.linspace(0.5, 2.0, 200)
    elastic = exact_law.tangent(RANDOM, definite=True)
    viscous = exact_law.tangent(RANDOM, start, None, 11.0) - exact_law.tangent(RANDOM, start, None, 0.0)
    both = exact_law.tangent(RANDOM, start, weight, 11.0, definite=True)
    expected = weight[:, None, None, None, None] * (elastic + viscous)
    np.testing.assert_allclose(both, expected, rtol=0, atol=1e-10 * abs(expected).max())


@pytest.mark.parametrize("F", DEGENERATE.values(), ids=DEGENERATE.keys())
def test_projection_of_collapsed_elements_is_semidefinite_too(law, F):
    values = np.linalg.eigvalsh(as_matrix(law.tangent(F[None], definite=True)[0]).astype(np.float64))
    tolerance = 1e-12 if law.types.numpy == np.float64 else 1e-5
    assert values[0] >= -tolerance * values[-1]


# --- Parameters --------------------------------------------------------------------------------------------------


def test_parameters_are_packed_in_the_documented_order():
    assert pack_parameters("stvk", 2.0, 3.0) == [2.0, 3.0, 0.0, 0.0, 0.0, 0.0]
    assert pack_parameters("mooney-rivlin", 1.0, 2.0, 3.0, 4.0, 5.0, 6.0) == [1.0, 2.0, 3.0, 4.0, 5.0, 6.0]


def test_a_wrong_number_of_constants_is_refused():
    with pytest.raises(ValueError, match="c10, c01, c11, c20, c02, bulk_modulus"):
        pack_parameters("mooney-rivlin", 2.0, 3.0)


@pytest.mark.parametrize("make", [lambda: pack_parameters("jelly", 1, 1), lambda: material_triple("jelly", "float64")])
def test_an_unknown_material_is_a_key_error(make):
    assert "jelly" not in MATERIALS
    with pytest.raises(KeyError):
        make()
