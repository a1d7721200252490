"""Volume kernels against NumPy, in both precisions, on batches."""

import numpy as np
import pytest
import warp as wp

from lingual.kernels.volume import volume_kernels

ELEMENTS, ROWS, TONGUES = 7, 6, 3


@pytest.fixture
def stacked():
    """Function seed -> displacement gradients (3 elements, 3, tongues), of moderate size."""
    return lambda seed: 0.3 * np.random.default_rng(seed).standard_normal((3 * ELEMENTS, 3, TONGUES))


@pytest.fixture
def run(types, device):
    """Function (name, size, inputs, outputs as NumPy, block) -> outputs after the launch."""

    def launch(name, size, inputs, outputs, block_dim=256):
        inputs = [
            wp.array(a, dtype=wp.int32 if a.dtype == np.int32 else types.scalar, device=device)
            if isinstance(a, np.ndarray)
            else a
            for a in inputs
        ]
        arrays = [wp.array(a, dtype=types.scalar, device=device) for a in outputs]
        kernel = getattr(volume_kernels(types.numpy.name), name)
        wp.launch(kernel, size, inputs, arrays, device=device, block_dim=block_dim)
        return [a.numpy() for a in arrays]

    return launch


def deformation(gradient):
    """F (elements, tongues, 3, 3)."""
    return np.eye(3) + gradient.reshape(ELEMENTS, 3, 3, TONGUES).transpose(0, 3, 2, 1)


def test_excess_is_det_f_minus_one(run, stacked, close):
    (excess,) = run("volume_excess", (ELEMENTS, TONGUES), [stacked(0)], [np.zeros((ELEMENTS, TONGUES))])
    close(excess, np.linalg.det(deformation(stacked(0))) - 1.0)


def test_excess_keeps_its_digits_near_rest(run, stacked, types):
    tiny = 1e-6 * stacked(0)
    (excess,) = run("volume_excess", (ELEMENTS, TONGUES), [tiny], [np.zeros((ELEMENTS, TONGUES))])
    divergence = np.einsum("ejjt->et", tiny.reshape(ELEMENTS, 3, 3, TONGUES))
    np.testing.assert_allclose(excess, divergence, rtol=1e-4, atol=1e-11)


def test_rate_is_the_derivative_of_det_f(run, stacked, types):
    G, dG = stacked(1), stacked(2)
    (rate,) = run("volume_rate", (ELEMENTS, TONGUES), [G, dG], [np.zeros((ELEMENTS, TONGUES))])
    h = 1e-5
    difference = (np.linalg.det(deformation(G + h * dG)) - np.linalg.det(deformation(G - h * dG))) / (2 * h)
    np.testing.assert_allclose(rate, difference, rtol=2e-5, atol=2e-6)


def test_cross_products_continue_with_unit_vectors(run, close):
    q = np.random.default_rng(3).standard_normal((ROWS, 3, TONGUES))
    pairs = np.array([[0, 1], [2, ROWS], [ROWS + 1, ROWS + 2]], dtype=np.int32)
    (cross,) = run("cross_products", (3, TONGUES), [q, pairs], [np.zeros((3, 3, TONGUES))])
    whole = np.concatenate([q, np.repeat(np.eye(3)[:, :, None], TONGUES, axis=2)])
    close(cross, np.cross(whole[pairs[:, 0]], whole[pairs[:, 1]], axis=1))


@pytest.mark.parametrize("row_count", [ROWS, ROWS + 3])
def test_step_is_the_change_over_the_slope(run, types, device, close, row_count):
    rng = np.random.default_rng(4)
    values, direction = rng.standard_normal((2, ROWS, 3, TONGUES))
    gradient = rng.standard_normal((ROWS + 3, 3, TONGUES))
    direction = direction * np.sign(np.sum(direction * gradient[:ROWS], axis=(0, 1)))
    lanes = 1 if device == "cpu" else 32
    inputs = [values, gradient, direction, types.scalar(0.25), row_count, lanes]
    change, step = run("volume_step", (TONGUES, lanes), inputs, [np.zeros(TONGUES)] * 2, block_dim=lanes)
    whole = np.concatenate([values, np.repeat(np.eye(3)[:, :, None], TONGUES, axis=2)])[:row_count]
    expected = 0.25 * np.sum(whole * gradient[:row_count], axis=(0, 1))
    close(change, expected)
    close(step, expected / np.sum(direction * gradient[:ROWS], axis=(0, 1)))


def test_no_slope_no_step(run, types, device):
    """A tongue whose volume nothing can change stays where it is instead of moving by infinity."""
    lanes = 1 if device == "cpu" else 32
    ones = np.ones((ROWS, 3, TONGUES))
    inputs = [ones, np.ones((ROWS + 3, 3, TONGUES)), 0.0 * ones, types.scalar(1.0), ROWS, lanes]
    _, step = run("volume_step", (TONGUES, lanes), inputs, [np.ones(TONGUES)] * 2, block_dim=lanes)
    assert np.all(step == 0.0)


def test_retreat_and_add(run, close):
    rng = np.random.default_rng(5)
    step, (direction, values) = rng.standard_normal(TONGUES), rng.standard_normal((2, ROWS, 3, TONGUES))
    close(run("retreat", values.shape, [step, direction], [values])[0], values - step * direction)
    close(run("add", values.shape, [direction], [values])[0], values + direction)
