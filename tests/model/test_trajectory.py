"""Trajectory: what it accepts, what it refuses and the views on it."""

from dataclasses import replace

import numpy as np
import pytest

from lingual.model import LingualError, Trajectory


@pytest.fixture
def trajectory():
    positions = np.arange(4 * 2 * 3, dtype=float).reshape(4, 2, 3)
    measured = np.array([[True, False, True], [True, True, True]])
    return Trajectory(np.array([0.0, 0.01, 0.02, 0.04]), ("TT", "TB"), positions, measured, source="a.csv")


def test_a_coordinate_that_was_not_measured_may_be_nan(trajectory):
    positions = trajectory.positions.copy()
    positions[2, 0, 1] = np.nan
    assert replace(trajectory, positions=positions).frame_count == 4


def test_rate_and_duration_come_from_the_times(trajectory):
    assert trajectory.duration == pytest.approx(0.04)
    assert trajectory.rate == pytest.approx(75.0)
    assert trajectory.head(1).rate == 0.0


def test_selecting_channels_reorders_all_that_belongs_to_them(trajectory):
    picked = trajectory.select(("TB", "TT"))
    assert picked.channels == ("TB", "TT")
    np.testing.assert_array_equal(picked.positions, trajectory.positions[:, ::-1])
    np.testing.assert_array_equal(picked.measured, trajectory.measured[::-1])


def test_head_keeps_the_first_frames(trajectory):
    first = trajectory.head(2)
    assert first.frame_count == len(first.positions) == len(first.jaw_translation) == 2


def nan_at(positions):
    positions = positions.copy()
    positions[2, 0, 2] = np.nan
    return positions


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda t: {"positions": t.positions[:3]}, "positions have shape"),
        (lambda t: {"measured": t.measured[:1]}, "positions have shape"),
        (lambda t: {"jaw_translation": np.zeros((2, 3))}, "the jaw has 2 frames, not 4"),
        (lambda t: {"frame": "skull"}, "frame is 'skull'"),
        (lambda t: {"channels": ("TT", "TT")}, "appears twice"),
        (lambda t: {"time": np.array([0.0, 0.01, 0.01, 0.02])}, "do not increase"),
        (lambda t: {"time": np.array([0.0, np.nan, 0.01, 0.02])}, "do not increase"),
        (lambda t: {"positions": nan_at(t.positions)}, "channel TT z is not finite at frame 2"),
    ],
)
def test_what_does_not_fit_is_refused_naming_the_source(trajectory, change, sentence):
    with pytest.raises(LingualError, match=f"^a.csv: .*{sentence}"):
        replace(trajectory, **change(trajectory))


def test_a_missing_channel_lists_what_there_is(trajectory):
    with pytest.raises(LingualError, match="no channel TR; it has TT, TB"):
        trajectory.select(("TR",))


def test_a_trajectory_without_frames_is_refused(trajectory):
    with pytest.raises(LingualError, match="no frame"):
        trajectory.head(0)
