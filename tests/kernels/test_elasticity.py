"""Elasticity kernels against NumPy, and the viscous part of an implicit step."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

RNG = np.random.default_rng(1)
F = np.eye(3) + 0.3 * RNG.standard_normal((7, 3, 3))
F_START = np.eye(3) + 0.3 * RNG.standard_normal((7, 3, 3))
WEIGHT = RNG.uniform(0.5, 2.0, 7)
DAMPING_OVER_STEP = 11.0

matrices = arrays(np.float64, (3, 3), elements=st.floats(-2.0, 2.0))


def linear(elasticity, strain):
    trace = np.trace(strain, axis1=-2, axis2=-1)[..., None, None]
    return 2.0 * elasticity.mu * strain + elasticity.lam * trace * np.eye(3)


def transposed(a):
    return np.swapaxes(a, -1, -2)


def oracle_stress(elasticity, F, F0, damping_over_step):
    elastic = F @ linear(elasticity, 0.5 * (transposed(F) @ F - np.eye(3)))
    rate = transposed(F0) @ (F - F0)
    return elastic + damping_over_step * F0 @ linear(elasticity, 0.5 * (rate + transposed(rate)))


def test_energy_and_det_f_match_numpy(elasticity, close):
    strain = 0.5 * (transposed(F) @ F - np.eye(3))
    expected = 0.5 * np.einsum("eij,eij->e", strain, linear(elasticity, strain))
    energy, det_f = elasticity.energy(F)
    close(energy, expected)
    close(det_f, np.linalg.det(F))


def test_stress_with_damping_matches_numpy(elasticity, close):
    stress = elasticity.stress(F, F_START, WEIGHT, DAMPING_OVER_STEP)
    close(stress, WEIGHT[:, None, None] * oracle_stress(elasticity, F, F_START, DAMPING_OVER_STEP))


def test_tangent_with_damping_is_the_derivative_of_the_stress(exact_elasticity):
    """The stress is cubic in F, so the central difference's error is h^2 times a constant."""
    tangent = exact_elasticity.tangent(F, F_START, WEIGHT, DAMPING_OVER_STEP)
    for m, n in np.ndindex(3, 3):
        dF = np.zeros((3, 3))
        dF[m, n] = 1e-5
        after, before = (exact_elasticity.stress(F + sign * dF, F_START, WEIGHT, DAMPING_OVER_STEP) for sign in (1, -1))
        np.testing.assert_allclose(tangent[..., m, n], (after - before) / 2e-5, rtol=0, atol=1e-8 * abs(tangent).max())


def test_single_precision_tangent_agrees_with_double(elasticity, exact_elasticity, close):
    arguments = (F, F_START, WEIGHT, DAMPING_OVER_STEP)
    close(elasticity.tangent(*arguments), exact_elasticity.tangent(*arguments))


def test_tangent_product_contracts_with_the_direction(elasticity, close):
    tangent = RNG.standard_normal((7, 3, 3, 3, 3))
    dF = RNG.standard_normal((7, 3, 3))
    close(elasticity.tangent_product(tangent, dF), np.einsum("eijmn,emn->eij", tangent, dF))


def test_at_rest_damping_is_damping_stiffness_times_the_elastic_stiffness(elasticity, close):
    rest = np.eye(3)[None]
    elastic = elasticity.tangent(rest)
    close(elasticity.tangent(rest, rest, None, DAMPING_OVER_STEP), (1.0 + DAMPING_OVER_STEP) * elastic)


def viscous_stress(elasticity, F, F0):
    return elasticity.stress(F, F0, None, 1.0) - elasticity.stress(F, F0, None, 0.0)


@settings(max_examples=30)
@given(F0=matrices, spin=arrays(np.float64, 3, elements=st.floats(-3.0, 3.0)))
def test_a_rigid_rotation_rate_is_not_damped_in_any_configuration(exact_elasticity, F0, spin):
    W = np.cross(np.eye(3), spin)
    stress = viscous_stress(exact_elasticity, (F0 + W @ F0)[None], F0[None])
    np.testing.assert_allclose(stress, 0.0, atol=1e-12 * exact_elasticity.lam * (1 + np.linalg.norm(F0)) ** 4 * 10)


@settings(max_examples=60)
@given(F0=matrices, F1=matrices)
def test_damping_never_feeds_energy_in(exact_elasticity, F0, F1):
    power = np.sum(viscous_stress(exact_elasticity, F1[None], F0[None])[0] * (F1 - F0))
    assert power >= -1e-9 * exact_elasticity.lam


def test_a_stretching_rate_is_damped(exact_elasticity):
    stress = viscous_stress(exact_elasticity, np.diag([1.1, 1.0, 1.0])[None], np.eye(3)[None])[0]
    assert stress[0, 0] == pytest.approx(0.1 * (2.0 * exact_elasticity.mu + exact_elasticity.lam))
