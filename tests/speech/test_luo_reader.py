"""Luo's recordings: values read off the sample files, and every way a file can be wrong."""

import numpy as np
import pytest

from lingual.model import LingualError
from lingual.speech import RecordingWarning, read_recording

FRAME_COUNTS = {"041": 752, "043": 460, "044": 856}


@pytest.mark.parametrize("name", FRAME_COUNTS)
def test_samples_have_their_announced_frames_rate_and_channels(shared_data, name):
    raw = read_recording(shared_data / f"ema/luo/20150624_0_{name}_sync.txt")
    assert raw.positions.shape == (FRAME_COUNTS[name], 7, 3)
    assert raw.channels == ("TR", "TD", "TB", "TT", "LI", "UL", "LL")
    np.testing.assert_allclose(np.diff(raw.time), 0.01, rtol=1e-9)
    assert raw.measured.tolist() == [[True, False, True]] * 7
    assert raw.frame == "head"


def test_values_of_the_first_sample(shared_data):
    raw = read_recording(shared_data / "ema/luo/20150624_0_041_sync.txt")
    first = {"TR": (80.653526, 115.446789), "TT": (41.825322, 127.471799), "LI": (36.101085, 136.376002)}
    for name, (x, y) in first.items():
        position = raw.positions[0, raw.channels.index(name)]
        assert position[[0, 2]] == pytest.approx((-x * 1e-3, -y * 1e-3), abs=1e-15)
        assert np.isnan(position[1])


def test_upper_lip_lies_above_lower_lip_and_tongue_lies_behind_the_teeth(shared_data):
    for file in sorted((shared_data / "ema/luo").glob("*.txt")):
        raw = read_recording(file)
        at = {name: raw.positions[:, c] for c, name in enumerate(raw.channels)}
        assert (at["UL"][:, 2] > at["LL"][:, 2] + 0.012).all()
        assert np.median(at["TR"][:, 0]) < np.median(at["TT"][:, 0]) < np.median(at["LI"][:, 0])


def test_format_is_found_by_content_not_by_name(write_luo, luo_rows):
    raw = read_recording(write_luo(luo_rows, "sentence.csv"))
    np.testing.assert_allclose(raw.positions[7, 3, [0, 2]], -luo_rows[7, 7:9] * 1e-3, atol=1e-9)


def test_windows_line_ends_and_byte_order_mark(write_luo, luo_rows):
    path = write_luo(luo_rows[:5])
    path.write_bytes(b"\xef\xbb\xbf" + path.read_bytes().replace(b"\n", b"\r\n"))
    assert len(read_recording(path).time) == 5


def test_a_time_column_is_ignored_with_a_warning(write_luo, luo_rows):
    rows = luo_rows[:10].copy()
    rows[:, 0] = np.arange(10)
    with pytest.warns(RecordingWarning, match="time column"):
        raw = read_recording(write_luo(rows))
    assert raw.time[-1] == pytest.approx(0.09)


def replaced_line(text: str, number: int, line: str) -> str:
    lines = text.splitlines(keepends=True)
    lines[number - 1] = line
    return "".join(lines)


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (lambda t: replaced_line(t, 1, "12 15\n"), "line 1 announces 12 rows, but 10 follow"),
        (lambda t: replaced_line(t, 1, "9 15\n"), "line 1 announces 9 rows, but 10 follow"),
        (lambda t: replaced_line(t, 1, "10 13\n"), "line 1: 13 columns"),
        (lambda t: replaced_line(t, 4, "0 1 2 3\n"), "line 4: 4 values where 15"),
        (lambda t: t.replace("0.0", "0.o", 1), r"line 2, column 1: '0.o00000' is not a number"),
        (lambda t: t[: len(t) // 2], r"line \d+: \d+ values|announces 10 rows"),
        (lambda t: t.rstrip(), "last line is not ended"),
        (lambda t: t.replace("4", "\0", 1), "this is not text"),
    ],
)
def test_damage_is_one_clear_sentence(write_luo, luo_rows, damage, message):
    path = write_luo(luo_rows[:10])
    path.write_text(damage(path.read_text()))
    with pytest.raises(LingualError, match=message) as error:
        read_recording(path)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


def test_files_that_are_no_recording(tmp_path):
    (tmp_path / "empty").write_bytes(b"")
    (tmp_path / "noise").write_bytes(bytes(range(256)) * 40)
    (tmp_path / "prose").write_text("Tongue twisters.\n")
    for name, message in {
        "absent": "There is no file",
        "empty": "is empty",
        "noise": "no known recording format; known are",
        "prose": "no known recording format; known are",
        ".": "is a directory",
        "nul\0": "cannot be read",
    }.items():
        with pytest.raises(LingualError, match=message):
            read_recording(tmp_path / name)
