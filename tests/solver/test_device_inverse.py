"""The inverse that follows the tangent on its device, against the one that LAPACK makes."""

import numpy as np
import pytest
import warp as wp

from lingual.precompute.reduction import all_element_model
from lingual.solver.device_inverse import DeviceInverse
from lingual.solver.lagged_inverse import LaggedInverse

STEP = 0.01


@pytest.fixture(scope="module", params=["cpu", pytest.param("cuda:0", marks=pytest.mark.gpu)])
def device(request):
    if request.param != "cpu" and not wp.is_cuda_available():
        pytest.skip("there is no CUDA device")
    return request.param


def _update(inverse):
    for stage in [*inverse.read, *inverse.iterate, inverse.accept]:
        stage()


@pytest.mark.parametrize("precision_name", ["float64", "float32"])
def test_it_follows_a_slow_motion(small_tongue, device, precision_name):
    model = all_element_model(small_tongue, 5)
    sagittal = np.ones((small_tongue.sensors.count, 3), dtype=bool)
    sagittal[:, 1] = False
    lagged = LaggedInverse(model, sagittal, "float64")
    direction = np.random.default_rng(3).standard_normal((model.column_count, 3, 1))
    direction *= 2e-3 / np.abs(model.basis @ direction[:, :, 0]).max()
    scalar = wp.float32 if precision_name == "float32" else wp.float64
    coordinates = wp.zeros(direction.shape, dtype=scalar, device=device)
    rest = np.zeros((model.column_count, 3))
    lagged.renew(rest, rest, STEP)
    inverse = DeviceInverse(model, lagged, coordinates, STEP, precision_name, device)
    inverse.assign(lagged.projected)
    first = lagged.projected.copy()
    for share in np.linspace(0.05, 1.0, 20):
        coordinates.assign(share * direction)
        _update(inverse)
    for _ in range(4):  # at rest in the last place the error is squared away
        _update(inverse)
    lagged.renew(direction[:, :, 0], direction[:, :, 0], STEP)
    found, size = inverse.inverse.numpy(), np.linalg.norm(lagged.projected)
    assert np.linalg.norm(first - lagged.projected) > 0.02 * size
    assert np.linalg.norm(found - lagged.projected) < (1e-9 if precision_name == "float64" else 1e-4) * size
    leak = np.linalg.norm(lagged.constraint_basis @ found)
    assert leak < (1e-12 if precision_name == "float64" else 1e-5) * size


@pytest.mark.parametrize("factor", [0.2, 20.0])
def test_it_comes_back_from_far_away(small_tongue, device, factor):
    """Where the undamped iteration diverges (beyond twice the inverse) or is slow."""
    model = all_element_model(small_tongue, 5)
    lagged = LaggedInverse(model, np.zeros((small_tongue.sensors.count, 3), dtype=bool), "float64")
    coordinates = wp.zeros((model.column_count, 3, 1), dtype=wp.float64, device=device)
    inverse = DeviceInverse(model, lagged, coordinates, STEP, "float64", device)
    rest = np.zeros((model.column_count, 3))
    lagged.renew(rest, rest, STEP)
    inverse.assign(factor * lagged.projected)
    for _ in range(12):
        _update(inverse)
    np.testing.assert_allclose(inverse.inverse.numpy(), lagged.projected, atol=1e-9 * np.abs(lagged.projected).max())


def test_what_is_beyond_repair_is_begun_again(small_tongue, device):
    model = all_element_model(small_tongue, 5)
    lagged = LaggedInverse(model, np.zeros((small_tongue.sensors.count, 3), dtype=bool), "float64")
    coordinates = wp.zeros((model.column_count, 3, 1), dtype=wp.float64, device=device)
    inverse = DeviceInverse(model, lagged, coordinates, STEP, "float64", device)
    rest = np.zeros((model.column_count, 3))
    lagged.renew(rest, rest, STEP)
    inverse.assign(lagged.projected)
    inverse.inverse.assign(np.full_like(lagged.projected, np.nan))
    _update(inverse)
    np.testing.assert_allclose(inverse.inverse.numpy(), lagged.projected, rtol=1e-12)
