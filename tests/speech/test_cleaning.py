"""Drop-outs, jumps and wrong units: bridged with a count, or refused by name."""

import warnings

import numpy as np
import pytest

from lingual.model import LingualError
from lingual.speech import RawRecording, RecordingWarning, clean

TIME = np.arange(400) / 100.0
CHANNELS = ("TT", "TB", "TD", "TR", "LI", "UL")


@pytest.fixture
def raw():
    """Six channels of slow motion [m], two-dimensional, 4 s at 100 Hz."""
    rest = -np.linspace(0.040, 0.090, len(CHANNELS))
    positions = np.full((len(TIME), len(CHANNELS), 3), np.nan)
    for c in range(len(CHANNELS)):
        positions[:, c, 0] = rest[c] + 0.004 * np.sin(2 * np.pi * 1.3 * TIME + c)
        positions[:, c, 2] = -0.1 + 0.006 * np.cos(2 * np.pi * 2.1 * TIME + c)
    measured = np.tile([True, False, True], (len(CHANNELS), 1))
    return RawRecording(TIME, CHANNELS, positions, measured, "sentence.txt")


def test_a_clean_recording_passes_unchanged_and_silently(raw):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        trajectory = clean(raw)
    np.testing.assert_array_equal(trajectory.positions, raw.positions)
    assert trajectory.channels == CHANNELS
    assert trajectory.frame == "head"


def test_the_samples_are_clean(shared_data):
    from lingual.speech import read_recording

    for file in sorted((shared_data / "ema/luo").glob("*.txt")):
        raw = read_recording(file)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            np.testing.assert_array_equal(clean(raw).positions, raw.positions)


@pytest.mark.parametrize("lost", [np.nan, np.inf, 1e3, -1e30, 0.0])
def test_a_drop_out_is_bridged_within_half_a_millimetre_and_counted(raw, lost):
    truth = raw.positions.copy()
    raw.positions[100:105, 1] = lost
    raw.positions[250, 1, 0] = np.nan
    missing = 6
    with pytest.warns(RecordingWarning, match=rf"TB has {missing} missing of 400 .* longest gap is 50 ms"):
        trajectory = clean(raw)
    axes = [0, 2]
    assert np.abs(trajectory.positions - truth)[:, :, axes].max() < 0.5e-3
    untouched = np.ones(400, dtype=bool)
    untouched[100:105] = untouched[250] = False
    np.testing.assert_array_equal(trajectory.positions[untouched], truth[untouched])


def test_bridges_do_not_overshoot(raw):
    raw.positions[50:60, 0, 2] = np.nan
    with pytest.warns(RecordingWarning):
        z = clean(raw).positions[:, 0, 2]
    ends = sorted([z[49], z[60]])
    assert (z[50:60] >= ends[0] - 1e-12).all()
    assert (z[50:60] <= ends[1] + 1e-12).all()


def test_lost_ends_hold_the_nearest_position(raw):
    raw.positions[:8, 2] = np.nan
    raw.positions[-8:, 2] = np.nan
    with pytest.warns(RecordingWarning, match="16 missing"):
        trajectory = clean(raw)
    np.testing.assert_array_equal(trajectory.positions[:8, 2, 2], trajectory.positions[8, 2, 2])
    np.testing.assert_array_equal(trajectory.positions[-8:, 2, 2], trajectory.positions[-9, 2, 2])


# An excursion of several frames is told from speech by its speed, which needs more than 10 mm at 100 Hz.
@pytest.mark.parametrize(
    ("size", "width"), [(0.008, 1), *((size, width) for size in (0.03, 0.2) for width in (1, 2, 3, 10))]
)
def test_a_spike_is_found_whatever_its_width(raw, size, width):
    truth = raw.positions.copy()
    raw.positions[200 : 200 + width, 3, 2] += size
    with pytest.warns(RecordingWarning, match=rf"TR has {width} jumping of 400"):
        trajectory = clean(raw)
    assert np.nanmax(np.abs(trajectory.positions - truth)) < 0.5e-3


def test_fast_speech_is_no_spike(raw):
    # 10 mm closures at 8 a second, 0.25 m/s and 12.6 m/s^2: faster than any tongue sustains.
    raw.positions[:, 0, 2] = -0.1 + 0.005 * np.sin(2 * np.pi * 8.0 * TIME)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        clean(raw)


def test_a_jump_that_stays_is_refused_with_channel_and_time(raw):
    raw.positions[150:, 0, 0] += 0.025
    with pytest.raises(LingualError, match=r"sentence.txt: channel TT jumps by 25 mm at 1.50 s and stays"):
        clean(raw)
    raw.positions[150:, 0, 0] -= 0.025
    raw.positions[:150, 0, 0] += 0.025
    with pytest.raises(LingualError, match=r"TT jumps by 25 mm at 1.50 s"):
        clean(raw)


@pytest.mark.parametrize(
    ("frames", "message"),
    [
        (slice(100, 130), r"channel TD is lost for 0.30 s from 1.00 s on"),
        (slice(0, 400, 3), r"channel TD has lost 34% of its samples"),
        (slice(0, 400), r"channel TD has no valid sample"),
    ],
)
def test_too_much_lost_on_the_tongue_is_refused(raw, frames, message):
    raw.positions[frames, 2] = np.nan
    with pytest.raises(LingualError, match=message):
        clean(raw)


def test_a_lost_lip_is_left_out(raw):
    raw.positions[100:300, 5] = np.nan
    with pytest.warns(RecordingWarning, match="channel UL .* left out"):
        assert clean(raw).channels == CHANNELS[:-1]


@pytest.mark.parametrize(
    ("factor", "message"),
    [
        (1e-3, "they look like metres: multiply them by 1000"),
        (100.0, "they look like 1/100 mm: multiply them by 0.01"),
        (1000.0, "they look like micrometres"),
        (1e-9, "scale them to millimetres"),
    ],
)
def test_another_unit_is_refused_with_its_factor(raw, factor, message):
    raw.positions[:] *= factor
    with pytest.raises(LingualError, match=message):
        clean(raw)


def test_normalised_values_are_refused(raw):
    raw.positions[:] = np.random.default_rng(0).normal(0.0, 1e-3, raw.positions.shape)
    with pytest.raises(LingualError, match="which no mouth does"):
        clean(raw)


def test_one_still_channel_is_no_wrong_unit():
    positions = np.tile([-0.04, 0.0, -0.1], (50, 1, 1))
    raw = RawRecording(np.arange(50) / 100, ("TT",), positions, np.ones((1, 3), dtype=bool), "still")
    np.testing.assert_array_equal(clean(raw).positions, positions)


def test_a_channel_resting_at_the_origin_is_not_lost():
    positions = np.zeros((200, 1, 3))
    positions[60:, 0, 2] = 0.005 * (1.0 - np.cos(2 * np.pi * np.arange(140) / 140))
    raw = RawRecording(np.arange(200) / 100, ("TT",), positions, np.ones((1, 3), dtype=bool), "ramp")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        np.testing.assert_array_equal(clean(raw).positions, positions)


def test_times_must_increase(raw):
    raw.time.flags.writeable = True
    time = raw.time.copy()
    time[5] = time[4]
    with pytest.raises(LingualError, match="times do not increase"):
        clean(RawRecording(time, raw.channels, raw.positions, raw.measured, "x"))
