"""Savitzky-Golay filter, change of rate, and removal of the jaw's motion."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from lingual.model import LingualError, Trajectory
from lingual.speech import RecordingWarning, remove_jaw_motion, resample, smooth
from lingual.speech.smoothing import smoothing_window


def trajectory(positions: np.ndarray, rate: float = 100.0, channels=("TT",), measured=None) -> Trajectory:
    measured = np.ones(positions.shape[1:], dtype=bool) if measured is None else measured
    return Trajectory(np.arange(len(positions)) / rate, channels, positions, measured)


def cubic(frames: int, rng: np.random.Generator) -> np.ndarray:
    """(frames, 1, 3): an independent random cubic per coordinate [m]."""
    t = np.linspace(-1.0, 1.0, frames)
    return np.stack([np.polyval(rng.normal(0, 0.02, 4), t) for _ in range(3)], axis=-1)[:, None]


@given(st.integers(21, 200), st.integers(0, 2**32 - 1))
def test_cubics_pass_unchanged_ends_included(frames, seed):
    motion = trajectory(cubic(frames, np.random.default_rng(seed)))
    np.testing.assert_allclose(smooth(motion).positions, motion.positions, atol=1e-12)


def test_the_middle_weight_is_that_of_21_frames_and_order_3():
    impulse = np.zeros((101, 1, 3))
    impulse[50] = 1.0
    smoothed = smooth(trajectory(impulse)).positions[:, 0, 0]
    # Savitzky and Golay (1964): quadratic/cubic, 21 points: 329/3059 at the middle, -171/3059 at the ends.
    assert smoothed[50] == pytest.approx(329 / 3059, abs=1e-12)
    assert smoothed[[40, 60]] == pytest.approx([-171 / 3059] * 2, abs=1e-12)
    assert np.abs(smoothed[:40]).max() < 1e-14


def test_noise_is_reduced_as_theory_says():
    noise = np.random.default_rng(0).normal(0.0, 1e-3, (20_000, 1, 3))
    assert smooth(trajectory(noise)).positions.std() == pytest.approx(1e-3 * np.sqrt(329 / 3059), rel=0.02)


def test_jaw_and_measured_coordinates_are_filtered_others_are_not():
    rng = np.random.default_rng(3)
    positions = rng.normal(0, 0.01, (60, 1, 3))
    positions[:, 0, 1] = np.nan
    measured = np.array([[True, False, True]])
    jaw = rng.normal(0, 0.01, (60, 3))
    both = Trajectory(np.arange(60) / 100, ("TT",), positions, measured, jaw_translation=jaw)
    smoothed = smooth(both)
    assert np.isnan(smoothed.positions[:, 0, 1]).all()
    np.testing.assert_allclose(smoothed.jaw_translation, smooth(trajectory(jaw[:, None])).positions[:, 0])
    assert smoothed.positions[:, 0, 0].std() < 0.5 * positions[:, 0, 0].std()


def test_the_window_keeps_its_time_at_other_rates():
    assert [smoothing_window(rate) for rate in (100.0, 200.0, 250.0, 500.0, 10.0)] == [21, 41, 51, 101, 5]


def test_short_recordings_are_filtered_less_with_a_warning():
    motion = trajectory(cubic(12, np.random.default_rng(0)))
    with pytest.warns(RecordingWarning, match="12 frames, so the filter's window is 11, not 21"):
        np.testing.assert_allclose(smooth(motion).positions, motion.positions, atol=1e-12)
    tiny = trajectory(np.random.default_rng(0).normal(0, 0.01, (4, 1, 3)))
    with pytest.warns(RecordingWarning, match="4 frames are too few"):
        np.testing.assert_array_equal(smooth(tiny).positions, tiny.positions)
    with pytest.warns(RecordingWarning, match="1 frames are too few"):
        smooth(trajectory(np.zeros((1, 1, 3))))


@pytest.mark.parametrize("window", [4, 3, 0, -1, 20])
def test_impossible_windows_are_refused(window):
    with pytest.raises(LingualError, match="must be odd and 5 or more"):
        smooth(trajectory(np.zeros((50, 1, 3))), window)


def test_uneven_times_are_refused():
    uneven = Trajectory(np.arange(50.0) ** 1.1, ("TT",), np.zeros((50, 1, 3)), np.ones((1, 3), dtype=bool))
    with pytest.raises(LingualError, match="not evenly spaced in time; resample"):
        smooth(uneven)


def test_resampling_keeps_duration_values_and_unmeasured_coordinates():
    t = np.arange(201) / 200.0
    positions = np.zeros((201, 1, 3))
    positions[:, 0, 0] = 0.01 * np.sin(2 * np.pi * 2.0 * t)
    positions[:, 0, 1] = np.nan
    jaw = np.stack([0.001 * t, 0.0 * t, -0.002 * t], axis=1)
    source = Trajectory(t, ("TT",), positions, np.array([[True, False, True]]), jaw_translation=jaw)
    halved = resample(source, 100.0)
    np.testing.assert_allclose(halved.time, np.arange(101) / 100.0, atol=1e-12)
    np.testing.assert_allclose(halved.positions[:, 0, 0], positions[::2, 0, 0], atol=1e-12)
    np.testing.assert_allclose(halved.jaw_translation, jaw[::2], atol=1e-12)
    assert np.isnan(halved.positions[:, 0, 1]).all()
    finer = resample(source, 1000.0)
    assert np.abs(finer.positions[:, 0, 0] - 0.01 * np.sin(2 * np.pi * 2.0 * finer.time)).max() < 5e-6


@pytest.mark.parametrize("rate", [0.0, -1.0, np.nan, np.inf, 1e12])
def test_impossible_rates_are_refused(rate):
    with pytest.raises(LingualError):
        resample(trajectory(np.zeros((50, 1, 3))), rate)


def test_jaw_motion_is_removed_exactly():
    rng = np.random.default_rng(5)
    jaw = rng.normal(0, 0.003, (40, 3))
    own = rng.normal(0, 0.01, (40, 2, 3))
    positions = np.concatenate([own + jaw[:, None], np.array([0.01, 0.0, -0.02]) + jaw[:, None]], axis=1)
    head = trajectory(positions, channels=("TT", "TB", "LI"))
    relative = remove_jaw_motion(head)
    assert relative.frame == "jaw"
    np.testing.assert_allclose(relative.jaw_translation, jaw - jaw[0], atol=1e-15)
    np.testing.assert_allclose(relative.positions[:, :2], own + jaw[0], atol=1e-15)
    np.testing.assert_allclose(np.ptp(relative.positions[:, 2], axis=0), 0.0, atol=1e-15)
    np.testing.assert_array_equal(relative.positions[0], head.positions[0])
    np.testing.assert_allclose(
        relative.positions + relative.jaw_translation[:, None], head.positions, atol=1e-15
    )


def test_a_coordinate_in_which_the_jaw_was_not_measured_counts_as_still():
    positions = np.random.default_rng(6).normal(0, 0.01, (30, 2, 3))
    positions[:, 1, 1] = np.nan
    measured = np.array([[True, True, True], [True, False, True]])
    relative = remove_jaw_motion(trajectory(positions, channels=("TT", "LI"), measured=measured))
    np.testing.assert_array_equal(relative.positions[:, 0, 1], positions[:, 0, 1])
    np.testing.assert_array_equal(relative.jaw_translation[:, 1], 0.0)


def test_jaw_motion_is_removed_once_and_needs_its_channel():
    motion = trajectory(np.zeros((5, 2, 3)), channels=("TT", "LI"))
    with pytest.raises(LingualError, match="removed already"):
        remove_jaw_motion(remove_jaw_motion(motion))
    with pytest.raises(LingualError, match="no channel MNI"):
        remove_jaw_motion(motion, "MNI")
