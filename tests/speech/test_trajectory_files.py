"""Lingual's CSV and npz: exact round trips, and malformed files."""

import tempfile
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from lingual.model import LingualError, Trajectory
from lingual.speech import read_recording, read_trajectory, write_trajectory

lengths = st.floats(-1e3, 1e3)
names = st.text(
    st.characters(categories=("L", "N", "P", "S"), exclude_characters='"#,;'), min_size=1, max_size=6
)


@st.composite
def trajectories(draw):
    """Any trajectory that a file may hold: few frames and channels, some coordinates not measured."""
    frames, channels = draw(st.integers(1, 5)), draw(st.integers(1, 3))
    steps = draw(st.lists(st.floats(1e-6, 10.0), min_size=frames, max_size=frames))
    measured = draw(arrays(bool, (channels, 3)))
    positions = draw(arrays(float, (frames, channels, 3), elements=lengths))
    if draw(st.booleans()):
        positions[:, ~measured] = np.nan
    return Trajectory(
        time=np.cumsum(steps),
        channels=tuple(
            draw(
                st.lists(
                    names.filter(lambda n: n != "jaw"), min_size=channels, max_size=channels, unique=True
                )
            )
        ),
        positions=positions,
        measured=measured,
        frame=draw(st.sampled_from(["head", "jaw"])),
        jaw_translation=draw(arrays(float, (frames, 3), elements=lengths)),
        source=draw(st.text(max_size=20)),
    )


def same_bits(a: np.ndarray, b: np.ndarray) -> bool:
    return a.shape == b.shape and a.tobytes() == b.tobytes()


@pytest.mark.parametrize("suffix", [".csv", ".npz"])
@given(trajectory=trajectories())
def test_round_trip_is_bit_for_bit(suffix, trajectory):
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"t{suffix}"
        write_trajectory(path, trajectory)
        back = read_trajectory(path)
    assert back.channels == trajectory.channels
    assert back.frame == trajectory.frame
    for name in ("time", "measured", "jaw_translation"):
        assert same_bits(getattr(back, name), getattr(trajectory, name)), name
    given_nan = np.isnan(trajectory.positions)
    assert np.array_equal(np.isnan(back.positions), given_nan)
    assert same_bits(back.positions[~given_nan], trajectory.positions[~given_nan])


@pytest.fixture
def csv(tmp_path):
    """Function that writes text as t.csv and returns the path."""

    def write(text: str) -> Path:
        path = tmp_path / "t.csv"
        path.write_text(text)
        return path

    return write


def test_a_plain_csv_made_elsewhere(csv):
    trajectory = read_trajectory(csv("time_s,TT_z_mm,TT_x_mm\n0.0,1.5,-20\n0.005, 1.75 ,-21.1\n"))
    assert trajectory.frame == "head"
    assert trajectory.measured.tolist() == [[True, False, True]]
    np.testing.assert_array_equal(trajectory.positions[:, 0, 0], [-0.020, -0.0211])
    np.testing.assert_array_equal(trajectory.positions[:, 0, 2], [0.0015, 0.00175])
    np.testing.assert_array_equal(trajectory.jaw_translation, np.zeros((2, 3)))
    assert trajectory.rate == pytest.approx(200.0)


def test_a_blank_column_is_not_measured(csv):
    trajectory = read_trajectory(csv("time_s,TT_x_mm,TT_y_mm,TT_z_mm\n0,1,,2\n1,1,,2\n"))
    assert trajectory.measured.tolist() == [[True, False, True]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("time_s\n0\n", "has no channel"),
        ("time_s,TT_x_mm\n", "no header row and frames"),
        ("time_s,TT_x\n0,1\n", "line 1, column 2: 'TT_x' is not of the form"),
        ("time_s,TT_x_mm,TT_x_mm\n0,1,1\n", "line 1, column 3: the column TT_x_mm appears twice"),
        ("time_s;TT_x_mm\n0;1\n", "separate columns with commas"),
        ("time,TT_x_mm\n0,1\n", "first column must be time_s"),
        ("time_s,TT_x_mm\n0,1\n0.1\n", "line 3: 1 cells where the header has 2"),
        ("time_s,TT_x_mm\n0,1\n0.1,one\n", "line 3, column TT_x_mm: 'one' is not a number"),
        ("time_s,TT_x_mm\n0,1_0\n", "line 2, column TT_x_mm"),
        ("time_s,TT_x_mm\n0,1\n0,2\n", "line 3: time 0.0 s is not later"),
        ("time_s,TT_x_mm\n0,1\nnan,2\n", "line 3: time nan"),
        ("time_s,TT_x_mm\n0,1\n1,\n", "TT x is not finite at frame 1"),
        ("time_s,TT_x_mm\n0,inf\n", "TT x is not finite at frame 0"),
        ("time_s,TT_x_mm,jaw_z_mm\n0,1,0\n1,1,\n", "the jaw's columns have no number in frame 1"),
        ("# lingual trajectory 2\ntime_s,TT_x_mm\n0,1\n", "line 1: trajectory format '2' is not known"),
        ("# frame: skull\ntime_s,TT_x_mm\n0,1\n", "line 1: the frame is 'skull'"),
        ("# frames: many\ntime_s,TT_x_mm\n0,1\n", "line 1: 'many' is not a number of frames"),
        ("# frames: 3\ntime_s,TT_x_mm\n0,1\n", "announces 3 frames, but 1 follow"),
        ("# frames: 1\ntime_s,TT_x_mm\n0,1", "last line is not ended"),
    ],
)
def test_malformed_csv(csv, text, message):
    path = csv(text)
    with pytest.raises(LingualError, match=message) as error:
        read_trajectory(path)
    assert str(path) in str(error.value)


def example(frames: int = 4) -> Trajectory:
    positions = np.random.default_rng(1).normal(0.0, 0.02, (frames, 2, 3))
    return Trajectory(np.arange(frames) / 100, ("TT", "TB"), positions, np.ones((2, 3), dtype=bool))


@pytest.mark.parametrize("suffix", [".csv", ".npz"])
def test_every_truncation_is_refused(tmp_path, suffix):
    path = tmp_path / f"t{suffix}"
    write_trajectory(path, example())
    content = path.read_bytes()
    for length in range(0, len(content), 1 if suffix == ".csv" else 13):
        path.write_bytes(content[:length])
        with pytest.raises(LingualError):
            read_trajectory(path)


@pytest.mark.parametrize("suffix", [".csv", ".npz"])
def test_flipped_bytes_give_a_trajectory_or_an_error_of_ours(tmp_path, suffix):
    path = tmp_path / f"t{suffix}"
    write_trajectory(path, example(20))
    content = path.read_bytes()
    rng = np.random.default_rng(2)
    for _ in range(300):
        damaged = bytearray(content)
        damaged[rng.integers(len(content))] ^= 1 << int(rng.integers(8))
        path.write_bytes(damaged)
        with suppress(LingualError):
            read_trajectory(path)


def test_npz_that_is_not_ours(tmp_path):
    np.savez(tmp_path / "other.npz", time=np.arange(3.0))
    with pytest.raises(LingualError, match="no Lingual trajectory"):
        read_recording(tmp_path / "other.npz")


def altered(arrays: dict, name: str) -> dict:
    changes = {
        "version": np.array(7),
        "time": np.array([0.0, 0.1, 0.1, 0.2]),
        "positions": np.zeros((4, 2)),
        "measured": np.ones((2, 3)),
        "frame": np.array("skull"),
        "jaw_translation": np.full((4, 3), np.nan),
    }
    return {**arrays, name: changes[name]}


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("version", "trajectory format 7"),
        ("time", "'time' does not increase at frame 2"),
        ("positions", "'positions' is float64 of dimension 2"),
        ("measured", "'measured' is float64"),
        ("frame", "'frame' is 'skull'"),
        ("jaw_translation", "'jaw_translation'"),
    ],
)
def test_malformed_npz(tmp_path, name, message):
    path = tmp_path / "t.npz"
    write_trajectory(path, example())
    with np.load(path) as file:
        arrays = dict(file)
    np.savez(path, **altered(arrays, name))
    with pytest.raises(LingualError, match=message):
        read_trajectory(path)


def test_no_pickle_is_ever_loaded(tmp_path):
    path = tmp_path / "t.npz"
    write_trajectory(path, example())
    with np.load(path) as file:
        arrays = dict(file)
    np.savez(path, **{**arrays, "channels": np.array(["TT", None], dtype=object)})
    with pytest.raises(LingualError, match="damaged archive"):
        read_trajectory(path)


def test_paths_that_cannot_be_written(tmp_path):
    with pytest.raises(LingualError, match=r"written as \.csv or \.npz"):
        write_trajectory(tmp_path / "t.mat", example())
    with pytest.raises(LingualError, match="cannot be written"):
        write_trajectory(tmp_path / "absent" / "t.csv", example())
    with pytest.raises(LingualError, match=r"ends in \.csv or \.npz"):
        read_trajectory(tmp_path / "t.mat")


@pytest.mark.parametrize("name", ["T T", "a,b", 'a"b', "jaw", "a\nb", "#a"])
def test_channel_names_that_a_header_cannot_hold(tmp_path, name):
    t = example()
    with pytest.raises(LingualError, match="cannot hold a channel called"):
        write_trajectory(tmp_path / "t.csv", Trajectory(t.time, (name, "TB"), t.positions, t.measured))
