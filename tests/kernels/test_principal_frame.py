"""The principal frame of a deformation, and strains without cancellation, against NumPy."""

import numpy as np
import pytest
import warp as wp
from scipy.spatial.transform import Rotation

from lingual.kernels.precision import precision
from lingual.kernels.principal_frame import principal_frame_functions
from lingual.kernels.strain import strain_functions

RNG = np.random.default_rng(11)
TURNS = Rotation.random(8, RNG).as_matrix()
DEFORMATIONS = np.concatenate(
    [
        np.eye(3)[None],
        np.zeros((1, 3, 3)),
        TURNS,
        TURNS @ np.diag([1.0, 1.0, -1.0]),  # equal stretches, mirrored
        TURNS @ np.diag([2.0, 2.0, 0.5]) @ TURNS[::-1],
        TURNS @ np.diag([1.3, 0.0, 0.0]) @ TURNS[::-1],
        TURNS @ np.diag([1.3, 0.7, 1e-7]) @ TURNS[::-1],
        np.eye(3) + 0.5 * RNG.standard_normal((100, 3, 3)),
        np.eye(3) + 1e-4 * RNG.standard_normal((20, 3, 3)),
    ]
)


@pytest.fixture(scope="module")
def frame_of(types, device):
    """Function F (n, 3, 3) -> (U, s, V, s - 1)."""
    p = types
    principal_frame = principal_frame_functions(p.numpy.name).principal_frame
    matrices, vectors = wp.array(dtype=p.mat33), wp.array(dtype=p.vec3)

    @wp.kernel(module="unique")
    def frames(
        F: matrices, U_out: matrices, stretch_out: vectors, V_out: matrices, strain_out: vectors
    ):
        """One thread finds one principal frame."""
        e = wp.tid()
        U, s, V, strain = principal_frame(F[e])
        U_out[e] = U
        stretch_out[e] = s
        V_out[e] = V
        strain_out[e] = strain

    def run(F):
        outputs = [wp.zeros(len(F), dtype=t, device=device) for t in (p.mat33, p.vec3, p.mat33, p.vec3)]
        wp.launch(frames, len(F), [wp.array(F, dtype=p.mat33, device=device)], outputs, device=device)
        return [out.numpy().astype(np.float64) for out in outputs]

    return run


@pytest.fixture(scope="module")
def rounding(types) -> float:
    return 1e-13 if types.numpy == np.float64 else 1e-5


def test_both_factors_are_rotations_and_give_back_the_deformation(frame_of, rounding):
    U, s, V, _ = frame_of(DEFORMATIONS)
    for Q in (U, V):
        np.testing.assert_allclose(Q @ Q.transpose(0, 2, 1), np.tile(np.eye(3), (len(Q), 1, 1)), atol=rounding)
        np.testing.assert_allclose(np.linalg.det(Q), 1.0, atol=rounding)
    # The square of the stretches is what is diagonalised, so the smallest of them keeps half of the digits.
    np.testing.assert_allclose(np.einsum("eik,ek,ejk->eij", U, s, V), DEFORMATIONS, atol=100.0 * rounding)


def test_stretches_are_singular_values_in_order_with_the_sign_of_the_determinant_on_the_least(frame_of, rounding):
    _, s, _, _ = frame_of(DEFORMATIONS)
    expected = np.linalg.svd(DEFORMATIONS, compute_uv=False)
    np.testing.assert_allclose(abs(s), expected, atol=10.0 * rounding)
    assert (s[:, :2] >= -10.0 * rounding).all()
    clear = abs(np.linalg.det(DEFORMATIONS)) > 1e-3
    np.testing.assert_array_equal(np.sign(s[clear, 2]), np.sign(np.linalg.det(DEFORMATIONS[clear])))


def test_the_undeformed_frame_is_exact(frame_of):
    U, s, V, strain = frame_of(np.eye(3)[None])
    assert np.array_equal(U[0], np.eye(3))
    assert np.array_equal(V[0], np.eye(3))
    assert np.array_equal(s[0], np.ones(3))
    assert not strain.any()


def test_stretch_less_one_is_that_of_the_stretches(frame_of, rounding):
    _, s, _, strain = frame_of(DEFORMATIONS)
    np.testing.assert_allclose(strain, s - 1.0, atol=100.0 * rounding)


def test_small_principal_strains_keep_their_digits_in_single_precision(device):
    """Strains of 1e-5 that single precision holds exactly beside 1: s - 1 itself has two digits there."""
    p = precision("float32")
    strain_of = principal_frame_functions("float32").principal_frame
    matrices, vectors = wp.array(dtype=p.mat33), wp.array(dtype=p.vec3)

    @wp.kernel(module="unique")
    def strains(F: matrices, strain_out: vectors):
        """One thread writes the principal strains of one deformation."""
        _U, _s, _V, strain = strain_of(F[wp.tid()])
        strain_out[wp.tid()] = strain

    steps = np.array([[180, 60, -120], [7, 7, 7], [300, -1, -299]]) * 2.0**-23
    F = np.eye(3) + steps[:, :, None] * np.eye(3)
    out = wp.zeros(3, dtype=p.vec3, device=device)
    wp.launch(strains, 3, [wp.array(F, dtype=p.mat33, device=device)], [out], device=device)
    np.testing.assert_allclose(out.numpy(), -np.sort(-steps, axis=1), rtol=1e-6)


def test_strain_and_volume_change_keep_their_digits(types, device):
    """For a strain of 1e-4 against extended precision; F^T F - I and det F - 1 would lose four digits."""
    p, f = types, strain_functions(types.numpy.name)
    matrices, scalars = wp.array(dtype=p.mat33), wp.array(dtype=p.scalar)
    green_strain, volume_change, cofactor = f.green_strain, f.volume_change, f.cofactor

    @wp.kernel(module="unique")
    def strains(F: matrices, strain_out: matrices, volume_out: scalars, cofactor_out: matrices):
        """One thread writes Green strain, det F - 1 and cof F of one deformation."""
        e = wp.tid()
        strain_out[e] = green_strain(F[e])
        volume_out[e] = volume_change(F[e])
        cofactor_out[e] = cofactor(F[e])

    F = (np.eye(3) + 1e-4 * RNG.standard_normal((50, 3, 3))).astype(p.numpy)
    E, J, cof = (wp.zeros(50, dtype=t, device=device) for t in (p.mat33, p.scalar, p.mat33))
    wp.launch(strains, 50, [wp.array(F, dtype=p.mat33, device=device)], [E, J, cof], device=device)
    G = F.astype(np.longdouble) - np.eye(3, dtype=np.longdouble)
    Gt = G.transpose(0, 2, 1)
    unit = np.finfo(p.numpy).eps
    np.testing.assert_allclose(E.numpy(), (0.5 * (G + Gt + Gt @ G)).astype(float), rtol=0, atol=4e-4 * 2.0 * unit)
    trace, square = np.trace(G, axis1=1, axis2=2), np.trace(G @ G, axis1=1, axis2=2)
    determinant = np.einsum("ei,ei->e", G[:, 0], np.cross(G[:, 1], G[:, 2]))
    change = trace + 0.5 * (trace**2 - square) + determinant
    np.testing.assert_allclose(J.numpy(), change.astype(float), rtol=0, atol=4e-4 * 4.0 * unit)
    exact = np.linalg.det(F.astype(float))[:, None, None] * np.linalg.inv(F.astype(float)).transpose(0, 2, 1)
    np.testing.assert_allclose(cof.numpy(), exact, rtol=0, atol=4.0 * unit)
