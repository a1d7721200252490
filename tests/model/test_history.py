"""StateHistory: interpolation, growth and the order of time."""

import numpy as np
import pytest

from lingual.model import StateHistory


def filled(frames: int, capacity: int = 2) -> StateHistory:
    """Frame i at time i / 10: nodes hold i, sensors 10 i, targets 20 i, the jaw 30 i."""
    history = StateHistory(node_count=2, sensor_count=1, capacity=capacity)
    for i in range(frames):
        one = np.full((1, 3), float(i))
        history.append(i / 10, np.full((2, 3), i), 10 * one, 20 * one, 30 * one[0], energy=float(i))
    return history


def test_between_frames_everything_is_interpolated_linearly():
    sample = filled(3).sample(0.125)
    np.testing.assert_allclose(sample.nodes, 1.25)
    np.testing.assert_allclose(sample.sensors, 12.5)
    np.testing.assert_allclose(sample.sensor_targets, 25.0)
    np.testing.assert_allclose(sample.jaw_translation, 37.5)


@pytest.mark.parametrize(("asked", "read"), [(-1.0, 0.0), (0.0, 0.0), (0.1, 1.0), (0.2, 2.0), (9.0, 2.0)])
def test_times_are_clamped_and_frames_are_hit_exactly(asked, read):
    sample = filled(3).sample(asked)
    assert sample.time == pytest.approx(read / 10)
    np.testing.assert_allclose(sample.nodes, read)


def test_growth_keeps_every_frame():
    history = filled(37, capacity=1)
    assert history.frame_count == 37
    np.testing.assert_allclose(history.time, np.arange(37) / 10)
    np.testing.assert_allclose(history.scalar("energy"), np.arange(37))
    np.testing.assert_allclose([history.sample(t).sensors[0, 0] for t in history.time], 10.0 * np.arange(37))


@pytest.mark.parametrize("time", [0.2, 0.1])
def test_time_must_advance(time):
    history = filled(3)
    with pytest.raises(ValueError, match="is not later than"):
        history.append(time, np.zeros((2, 3)), np.zeros((1, 3)), np.zeros((1, 3)), np.zeros(3))
    assert history.frame_count == 3


def test_a_scalar_that_a_frame_did_not_give_is_nan():
    history = filled(2)
    history.append(0.5, np.zeros((2, 3)), np.zeros((1, 3)), np.zeros((1, 3)), np.zeros(3), volume=1.0)
    np.testing.assert_array_equal(history.scalar("energy"), [0.0, 1.0, np.nan])
    np.testing.assert_array_equal(history.scalar("volume"), [np.nan, np.nan, 1.0])
    assert np.isnan(history.scalar("unknown")).all()
    assert history.scalar_names == ("energy", "volume")
