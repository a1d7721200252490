"""Readers of recordings, one module a file format; the format is found from the file's content.

A new format is a module with a RecordingFormat, listed in FORMATS. Formats with a mark of their own come
before those that are recognised by their shape alone.
"""

from pathlib import Path

from ...model.errors import LingualError
from ...model.text_files import read_bytes
from ..raw_recording import RawRecording, RecordingFormat
from ..trajectory_files import CSV_FORMAT, NPZ_FORMAT
from . import luo

FORMATS: tuple[RecordingFormat, ...] = (NPZ_FORMAT, CSV_FORMAT, luo.FORMAT)

_START = 4096  # bytes that a format may look at to recognise its files


def read_recording(path: Path | str) -> RawRecording:
    """The recording or trajectory in a file, as it stands there: nothing is bridged or filtered.

    Raises LingualError when the file cannot be read, is of no known format (the message lists them) or
    is damaged.
    """
    path = Path(path)
    start = read_bytes(path, _START)
    for kind in FORMATS:
        if kind.recognises(path, start):
            return kind.read(path)
    known = "; ".join(kind.name for kind in FORMATS)
    raise LingualError(f"{path} is in no known recording format; known are: {known}.")
