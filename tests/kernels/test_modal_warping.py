"""Modal-warping kernels against quadrature of rotations (the mean), SciPy's rotations and complex steps."""

import numpy as np
import pytest
import warp as wp
from scipy.spatial.transform import Rotation

from lingual.kernels.modal_warping import SERIES_LIMIT, modal_warping_kernels

RNG = np.random.default_rng(11)
TONGUES, NODES, MODES = 3, 40, 7
ANGLES = (0.0, 1e-9, 1e-4, 0.1, 0.999 * SERIES_LIMIT**0.5, 1.001 * SERIES_LIMIT**0.5, 2.0, np.pi, 5.0)


def rotated(w: np.ndarray, a: np.ndarray) -> np.ndarray:
    """exp([w]) a by Rodrigues' formula, of vectors along the last axis; also for complex w."""
    t = np.sqrt(np.sum(w * w, axis=-1, keepdims=True)) / np.pi
    turned = np.cross(w, a)
    return a + np.sinc(t) * turned + 0.5 * np.sinc(0.5 * t) ** 2 * np.cross(w, turned)


def mean_rotated(w: np.ndarray, a: np.ndarray) -> np.ndarray:
    """The integral of exp(s [w]) a over s from 0 to 1, by Gauss quadrature."""
    places, weights = np.polynomial.legendre.leggauss(24)
    terms = (0.5 * weight * rotated(0.5 * (s + 1.0) * w, a) for s, weight in zip(places, weights, strict=True))
    return sum(terms)


def linear_points() -> np.ndarray:
    """a and w of NODES nodes, interleaved, in TONGUES tongues; every angle of ANGLES occurs."""
    points = RNG.standard_normal((2 * NODES, 3, TONGUES))
    w = points[1::2]
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    w *= np.resize(ANGLES, (NODES, 1, TONGUES))
    return points


LINEAR = linear_points()


@pytest.fixture
def kernels(types):
    return modal_warping_kernels(types.numpy.name)


def test_the_linear_part_is_rows_times_coordinates(kernels, types, launch, close):
    rows, q = RNG.standard_normal((2 * NODES * 3, MODES)), RNG.standard_normal((MODES, 1, TONGUES))
    inputs = [(rows, types.scalar), (q, types.scalar)]
    linear = launch(kernels.linear_part, LINEAR.shape, inputs, LINEAR.shape, types.scalar)
    close(linear, (rows @ q[:, 0]).reshape(LINEAR.shape))


def test_a_node_moves_by_the_mean_of_its_rotations(kernels, types, launch, close):
    """Of 50 nodes 40 move; the others are not written."""
    nodes = RNG.permutation(50)[:NODES].astype(np.int32)
    rest = RNG.standard_normal((50, 3))
    expected = np.zeros((50, 3, TONGUES))
    for t in range(TONGUES):
        expected[nodes, :, t] = rest[nodes] + mean_rotated(LINEAR[1::2, :, t], LINEAR[::2, :, t])
    inputs = [(nodes, wp.int32), (rest, types.vec3), (LINEAR, types.scalar)]
    close(launch(kernels.warp, (NODES, TONGUES), inputs, expected.shape, types.scalar), expected)


def test_a_load_is_turned_back_by_the_rotation_of_its_node(kernels, types, launch, close):
    masses, acceleration = RNG.random(NODES), RNG.standard_normal((TONGUES, 3))
    expected = np.zeros_like(LINEAR)
    for t in range(TONGUES):
        turned = Rotation.from_rotvec(LINEAR[1::2, :, t]).inv().apply(acceleration[t])
        expected[::2, :, t] = masses[:, None] * turned
    inputs = [(masses, types.scalar), (acceleration, types.vec3), (LINEAR, types.scalar)]
    close(launch(kernels.rotated_load, (NODES, TONGUES), inputs, LINEAR.shape, types.scalar), expected)


SENSORS, UNDER = NODES // 5, 5
WEIGHTS = RNG.dirichlet(np.ones(UNDER), SENSORS)


def sensor_displacement(linear: np.ndarray) -> np.ndarray:
    """Weighted mean of the warped displacements under each sensor, of one tongue's (2 NODES, 3)."""
    moved = mean_rotated(linear[1::2], linear[::2])
    return np.einsum("sk,ski->si", WEIGHTS, moved.reshape(SENSORS, UNDER, 3))


@pytest.fixture
def sensor_warp(kernels, types, device):
    """Function linear -> displacement (SENSORS, 3, TONGUES) and slope (SENSORS, 3, 6 UNDER, TONGUES)."""
    displacement = wp.zeros((SENSORS, 3, TONGUES), dtype=types.scalar, device=device)
    slope = wp.zeros((SENSORS, 3, 6 * UNDER, TONGUES), dtype=types.scalar, device=device)
    inputs = [wp.array(values, dtype=types.scalar, device=device) for values in (LINEAR, WEIGHTS)]
    wp.launch(kernels.sensor_warp, (SENSORS, TONGUES), inputs, [displacement, slope], device=device)
    return displacement.numpy(), slope.numpy()


def test_a_sensor_follows_the_weighted_mean_of_its_nodes(sensor_warp, close):
    expected = np.stack([sensor_displacement(LINEAR[:, :, t]) for t in range(TONGUES)], axis=-1)
    close(sensor_warp[0], expected)


def test_the_slope_of_a_sensor_is_the_derivative_of_its_displacement(sensor_warp, close):
    """Complex steps through the quadrature: exact to rounding."""
    expected = np.empty((SENSORS, 3, 6 * UNDER, TONGUES))
    step = 1e-30
    for t in range(TONGUES):
        for column in range(6 * UNDER):
            moved = LINEAR[:, :, t].astype(complex)
            place = 2 * np.arange(SENSORS) * UNDER + column // 3
            moved[place, column % 3] += 1j * step
            expected[:, :, column, t] = sensor_displacement(moved).imag / step
    close(sensor_warp[1], expected)
