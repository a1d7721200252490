"""Recordings of the subject of Luo (2017), section 4: coils on tongue, jaw and lips.

Text. First line: number of rows and of columns (15). Then one row per frame, 100 Hz: a time (always 0),
and x and y [mm] of TR, TD, TB, TT, LI (lower incisor), UL and LL (upper and lower lip; the upper one is the
one that lies 18 to 22 mm above the other in all recordings). In the file x grows backwards and y downwards.

The recordings are midsagittal, so x and z are measured and y is not. Coordinates keep the recording's own
origin (no point of the skull is in the file), which is also that of the subject's mesh.
"""

import re
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...model.errors import LingualError
from ...model.text_files import check_last_line_ended, parse_number, read_text
from ...model.units import M_PER_MM
from ..raw_recording import RawRecording, RecordingFormat
from ..recording_warning import warn

CHANNELS = ("TR", "TD", "TB", "TT", "LI", "UL", "LL")
"""In the order of the columns."""

RATE = 100.0
"""Frames a second [Hz] (Luo 2017, section 4)."""

COLUMN_COUNT = 1 + 2 * len(CHANNELS)

_HEADER = re.compile(rb"[ \t]*\d{1,9}[ \t]+\d{1,9}[ \t]*\r?\n")


def recognises(path: Path, start: bytes) -> bool:
    """Whether the file begins with a line of two counts, whatever its name."""
    return _HEADER.match(start.removeprefix(b"\xef\xbb\xbf")) is not None


def read(path: Path) -> RawRecording:
    """Reads one recording.

    Raises LingualError, naming the line, when a row is not numbers, has another number of columns, or
    when there are more or fewer rows than the first line says.
    """
    text = read_text(path)
    lines = text.splitlines()
    row_count, column_count = (int(token) for token in lines[0].split())
    if column_count != COLUMN_COUNT:
        raise LingualError(
            f"{path}, line 1: {column_count} columns are announced, but a recording of Luo has "
            f"{COLUMN_COUNT} (time, then x and y of {', '.join(CHANNELS)})."
        )
    rows = [_row(path, i, line) for i, line in enumerate(lines[1:], start=2) if line.strip()]
    if len(rows) != row_count:
        raise LingualError(
            f"{path}: line 1 announces {row_count} rows, but {len(rows)} follow; "
            "the file is cut short or its first line is wrong: copy it again."
        )
    check_last_line_ended(path, text)
    return _recording(path, np.array(rows, dtype=np.float64).reshape(row_count, COLUMN_COUNT))


def _row(path: Path, line_number: int, line: str) -> list[float]:
    tokens = line.split()
    if len(tokens) != COLUMN_COUNT:
        raise LingualError(
            f"{path}, line {line_number}: {len(tokens)} values where {COLUMN_COUNT} are needed; "
            "the file is damaged or cut short: copy it again."
        )
    values = []
    for column, token in enumerate(tokens, start=1):
        try:
            values.append(parse_number(token))
        except ValueError as error:
            raise LingualError(
                f"{path}, line {line_number}, column {column}: '{token[:30]}' is not a number; "
                "correct it, or write nan for a lost sample."
            ) from error
    return values


def _recording(path: Path, rows: NDArray[np.float64]) -> RawRecording:
    """From rows (frame_count, 15) in the file's unit and axes."""
    if np.any(rows[:, 0] != 0.0):
        warn(str(path), f"its time column is not zero and is ignored; {RATE:.0f} Hz are assumed.")
    frame_count = len(rows)
    xy = rows[:, 1:].reshape(frame_count, len(CHANNELS), 2)
    positions = np.full((frame_count, len(CHANNELS), 3), np.nan)
    positions[:, :, 0] = -xy[:, :, 0] * M_PER_MM
    positions[:, :, 2] = -xy[:, :, 1] * M_PER_MM
    return RawRecording(
        time=np.arange(frame_count) / RATE,
        channels=CHANNELS,
        positions=positions,
        measured=np.tile([True, False, True], (len(CHANNELS), 1)),
        source=str(path),
    )


FORMAT = RecordingFormat("Luo's text (rows and columns, then 15 numbers a line)", recognises, read)
