"""The dense constrained solver against NumPy on the whole block system."""

import numpy as np
import pytest

from lingual.model.saddle_point import solve_saddle_point

RNG = np.random.default_rng(4)
SIZE = 12


def symmetric(kind: str) -> np.ndarray:
    A = RNG.standard_normal((SIZE, SIZE))
    return A @ A.T + np.eye(SIZE) if kind == "definite" else A + A.T


@pytest.mark.parametrize("constraints", [0, 1, 4])
@pytest.mark.parametrize("kind", ["definite", "indefinite"])
@pytest.mark.parametrize(("dtype", "tolerance"), [(np.float64, 1e-10), (np.float32, 2e-3)])
def test_solution_matches_the_whole_system(kind, constraints, dtype, tolerance):
    A, J = symmetric(kind), RNG.standard_normal((constraints, SIZE))
    f, g = RNG.standard_normal(SIZE), RNG.standard_normal(constraints)
    x, y = solve_saddle_point(*(a.astype(dtype) for a in (A, J, f, g)))
    whole = np.block([[A, J.T], [J, np.zeros((constraints, constraints))]])
    expected = np.linalg.solve(whole, np.concatenate([f, g]))
    assert x.dtype == y.dtype == dtype
    np.testing.assert_allclose(np.concatenate([x, y]), expected, rtol=tolerance, atol=tolerance * abs(expected).max())


def test_the_inputs_are_left_alone():
    A, J, f, g = symmetric("definite"), np.ones((1, SIZE)), np.ones(SIZE), np.ones(1)
    copies = [a.copy() for a in (A, J, f, g)]
    solve_saddle_point(A, J, f, g)
    for before, after in zip(copies, (A, J, f, g), strict=True):
        np.testing.assert_array_equal(before, after)


@pytest.mark.parametrize("scale", [0.0, 1.0])
def test_a_singular_system_is_an_error(scale):
    repeated = np.ones((2, SIZE))
    with pytest.raises(np.linalg.LinAlgError):
        solve_saddle_point(scale * np.eye(SIZE), repeated, np.ones(SIZE), np.ones(2))
