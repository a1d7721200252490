"""The CSV form of a trajectory: comment lines, a header row, one row a frame.

    # lingual trajectory 1
    # frame: jaw
    # frames: 752
    # not measured: TT_y TB_y
    # source: where it came from
    time_s,TT_x_mm,TT_y_mm,TT_z_mm,...,jaw_x_mm,jaw_y_mm,jaw_z_mm
    0.0,-41.8,,-127.4,...

Only the header row and the rows are needed; see docs/formats.md.
"""

import re
from dataclasses import dataclass, field
from decimal import Decimal, InvalidOperation
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..model.errors import LingualError
from ..model.text_files import check_last_line_ended, parse_number, read_text
from ..model.trajectory import Trajectory
from .raw_recording import RawRecording, RecordingFormat

VERSION = 1
_MARK = "# lingual trajectory"
_COLUMN = re.compile(r"(.+)_([xyz])_mm")
_BLANK = ("", "nan", "NaN", "NA")


def csv_text(trajectory: Trajectory) -> str:
    """The whole file as text."""
    names = [*trajectory.channels, "jaw"]
    unmeasured = [
        f"{name}_{'xyz'[axis]}"
        for name, row in zip(trajectory.channels, trajectory.measured, strict=True)
        for axis in range(3)
        if not row[axis]
    ]
    lines = [
        f"{_MARK} {VERSION}",
        "# x anterior, y left, z up; lengths in mm, time in s; a blank cell was not recorded",
        f"# frame: {trajectory.frame}",
        f"# frames: {trajectory.frame_count}",
        f"# not measured: {' '.join(unmeasured)}",
        f"# source: {_one_line(trajectory.source)}",
        ",".join(["time_s", *(f"{name}_{axis}_mm" for name in names for axis in "xyz")]),
    ]
    values = np.concatenate([trajectory.positions, trajectory.jaw_translation[:, None]], axis=1)
    for time, row in zip(trajectory.time.tolist(), values.reshape(len(values), -1).tolist(), strict=True):
        lines.append(",".join([repr(time), *map(_millimetres, row)]))
    return "\n".join(lines) + "\n"


def _one_line(text: str) -> str:
    """Text fit for a comment line: blanks joined, what cannot be printed or encoded replaced."""
    printable = "".join(c if c.isprintable() else "?" for c in " ".join(text.split()))
    return printable.encode("utf-8", "replace").decode("utf-8")


def _millimetres(metres: float) -> str:
    """Text of a length in mm that _metres turns back into the same float; blank for NaN."""
    return "" if metres != metres else str(Decimal(repr(metres)).scaleb(3))


def _metres(token: str) -> float:
    """Length [m] of a cell in mm; NaN for a blank one. Raises ValueError for what is not a number."""
    if token in _BLANK:
        return float("nan")
    parse_number(token)
    try:
        return float(Decimal(token).scaleb(-3))
    except InvalidOperation as error:
        raise ValueError(token) from error


def recognises(path: Path, start: bytes) -> bool:
    """Whether the file begins with our mark, or with a header row whose first column is time_s."""
    text = start.removeprefix(b"\xef\xbb\xbf").decode("utf-8", "replace")
    if text.startswith(_MARK):
        return True
    rows = [line for line in text.splitlines() if line.strip() and not line.startswith("#")]
    return bool(rows) and re.match(r"\"?time_s\b", rows[0]) is not None


@dataclass
class _Comments:
    """What the comment lines say; everything is optional."""

    frame: str = "head"
    frame_count: int | None = None
    unmeasured: set[str] = field(default_factory=set)


def read(path: Path) -> RawRecording:
    """Reads a CSV trajectory. Raises LingualError, naming line and column, for anything malformed."""
    text = read_text(path)
    comments = _Comments()
    columns: list[str] | None = None
    rows: list[list[float]] = []
    line_of_row: list[int] = []
    for number, line in enumerate(text.splitlines(), start=1):
        if line.startswith("#"):
            _read_comment(path, number, line, comments)
        elif not line.strip():
            continue
        elif columns is None:
            columns = _read_header(path, number, line)
        else:
            rows.append(_read_row(path, number, line, columns))
            line_of_row.append(number)
    if columns is None or not rows:
        raise LingualError(f"{path} has no header row and frames: it is cut short; export it again.")
    if comments.frame_count is not None:
        if comments.frame_count != len(rows):
            raise LingualError(
                f"{path} announces {comments.frame_count} frames, but {len(rows)} follow: "
                "it is cut short; export it again, or correct its '# frames:' line."
            )
        check_last_line_ended(path, text)
    table = np.array(rows)
    _check_times(path, table[:, 0], line_of_row)
    return _recording(path, comments, columns, table)


def _read_comment(path: Path, number: int, line: str, comments: _Comments) -> None:
    if line.startswith(_MARK):
        version = line[len(_MARK) :].strip()
        if version != str(VERSION):
            raise LingualError(
                f"{path}, line {number}: trajectory format '{version[:20]}' is not known, only {VERSION}: "
                "install a newer Lingual."
            )
        return
    key, colon, value = line[1:].partition(":")
    value = value.strip()
    if not colon:
        return
    if key.strip() == "frame":
        if value not in ("head", "jaw"):
            raise LingualError(f"{path}, line {number}: the frame is '{value[:30]}'; write 'head' or 'jaw'.")
        comments.frame = value
    elif key.strip() == "frames":
        if not (value.isascii() and value.isdigit()):
            raise LingualError(f"{path}, line {number}: '{value[:30]}' is not a number of frames.")
        comments.frame_count = int(value[:18])
    elif key.strip() == "not measured":
        comments.unmeasured = set(value.split())


def _read_header(path: Path, number: int, line: str) -> list[str]:
    columns = [token.strip().strip('"') for token in line.split(",")]
    if columns[0] != "time_s":
        hint = "; separate columns with commas" if ";" in line or "\t" in line else ""
        raise LingualError(
            f"{path}, line {number}: the first column must be time_s, not '{columns[0][:30]}'{hint}."
        )
    for i, name in enumerate(columns[1:], start=2):
        if not _COLUMN.fullmatch(name):
            raise LingualError(
                f"{path}, line {number}, column {i}: '{name[:40]}' is not of the form CHANNEL_x_mm, "
                "CHANNEL_y_mm or CHANNEL_z_mm: rename or remove it."
            )
        if name in columns[1 : i - 1]:
            raise LingualError(f"{path}, line {number}, column {i}: the column {name} appears twice.")
    return columns


def _read_row(path: Path, number: int, line: str, columns: list[str]) -> list[float]:
    tokens = [token.strip() for token in line.split(",")]
    if len(tokens) != len(columns):
        raise LingualError(
            f"{path}, line {number}: {len(tokens)} cells where the header has {len(columns)}; "
            "the line is damaged or cut short."
        )
    row = []
    for i, token in enumerate(tokens):
        try:
            row.append(_metres(token) if i else parse_number(token))
        except ValueError as error:
            raise LingualError(
                f"{path}, line {number}, column {columns[i]}: '{token[:30]}' is not a number; "
                "correct it, or leave the cell blank for a lost sample."
            ) from error
    return row


def _check_times(path: Path, time: NDArray[np.float64], line_of_row: list[int]) -> None:
    bad = np.flatnonzero(~np.isfinite(time) | (np.diff(time, prepend=-np.inf) <= 0.0))
    if len(bad):
        raise LingualError(
            f"{path}, line {line_of_row[bad[0]]}: time {time[bad[0]]} s is not later than the line before; "
            "times must increase."
        )


def _recording(
    path: Path, comments: _Comments, columns: list[str], table: NDArray[np.float64]
) -> RawRecording:
    """Sorts the columns of table (frame_count, column_count) [s, m] into channels, in order of appearance."""
    found = [_COLUMN.fullmatch(name) for name in columns[1:]]
    keys = [(m.group(1), "xyz".index(m.group(2))) for m in found if m]
    channels = tuple(dict.fromkeys(name for name, _ in keys if name != "jaw"))
    if not channels:
        raise LingualError(f"{path} has no channel: its header names no column but time_s and the jaw's.")
    positions = np.full((len(table), len(channels), 3), np.nan)
    jaw = np.zeros((len(table), 3))
    for i, (name, axis) in enumerate(keys, start=1):
        if name == "jaw":
            jaw[:, axis] = table[:, i]
        else:
            positions[:, channels.index(name), axis] = table[:, i]
    bad_jaw = np.flatnonzero(~np.isfinite(jaw).all(axis=1))
    if len(bad_jaw) == len(jaw):
        jaw[:] = 0.0
    elif len(bad_jaw):
        raise LingualError(f"{path}: the jaw's columns have no number in frame {bad_jaw[0]}; fill it in.")
    measured = ~np.isnan(positions).all(axis=0)
    for c, name in enumerate(channels):
        for axis in range(3):
            measured[c, axis] &= f"{name}_{'xyz'[axis]}" not in comments.unmeasured
    return RawRecording(table[:, 0], channels, positions, measured, str(path), comments.frame, jaw)


CSV_FORMAT = RecordingFormat("Lingual's CSV (time_s, TT_x_mm, ...)", recognises, read)
