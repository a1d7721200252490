"""The npz form of a trajectory: the arrays of Trajectory as they are (SI), a format mark and a version."""

import io
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..model.errors import LingualError
from ..model.text_files import read_bytes
from ..model.trajectory import Trajectory
from .raw_recording import RawRecording, RecordingFormat

VERSION = 1
_MARK = "lingual trajectory"
_ARRAYS = {
    "format": ("U", 0),
    "version": ("i", 0),
    "time": ("f", 1),
    "channels": ("U", 1),
    "positions": ("f", 3),
    "measured": ("b", 2),
    "frame": ("U", 0),
    "jaw_translation": ("f", 2),
    "source": ("U", 0),
}
"""Kind of number and dimension of each array."""


def save_npz(path: Path, trajectory: Trajectory) -> None:
    """Writes the file. Raises OSError when it cannot be written."""
    with open(path, "wb") as file:
        np.savez(
            file,
            format=np.array(_MARK),
            version=np.array(VERSION),
            time=trajectory.time,
            channels=np.array(trajectory.channels, dtype=np.str_),
            positions=trajectory.positions,
            measured=trajectory.measured,
            frame=np.array(trajectory.frame),
            jaw_translation=trajectory.jaw_translation,
            source=np.array(trajectory.source),
        )


def recognises(path: Path, start: bytes) -> bool:
    """Whether the file is a zip archive, as every npz is."""
    return start.startswith(b"PK\x03\x04")


def read(path: Path) -> RawRecording:
    """Reads an npz trajectory. Raises LingualError, naming the array, for a foreign or damaged file."""
    arrays = _arrays(path, read_bytes(path))
    version = int(arrays["version"])
    if version != VERSION:
        raise LingualError(f"{path}: trajectory format {version} is not known: update Lingual.")
    time = arrays["time"].astype(np.float64)
    bad = np.flatnonzero(~np.isfinite(time) | (np.diff(time, prepend=-np.inf) <= 0.0))
    if len(bad):
        raise LingualError(f"{path}: the array 'time' does not increase at frame {bad[0]}: correct it.")
    jaw = arrays["jaw_translation"].astype(np.float64)
    if not np.isfinite(jaw).all():
        raise LingualError(f"{path}: the array 'jaw_translation' holds values that are not finite.")
    if str(arrays["frame"]) not in ("head", "jaw"):
        raise LingualError(f"{path}: the array 'frame' is '{arrays['frame']}'; it must be 'head' or 'jaw'.")
    return RawRecording(
        time=time,
        channels=tuple(str(name) for name in arrays["channels"]),
        positions=arrays["positions"].astype(np.float64),
        measured=arrays["measured"],
        source=str(path),
        frame=str(arrays["frame"]),
        jaw_translation=jaw,
    )


def _arrays(path: Path, content: bytes) -> dict[str, NDArray]:
    # A damaged archive raises anything from BadZipFile and zlib.error to UnicodeDecodeError and MemoryError.
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            arrays = {name: file[name] for name in _ARRAYS if name in file.files}
    except Exception as error:
        raise LingualError(f"{path} is a damaged archive ({error}): copy or export it again.") from error
    if str(arrays.get("format")) != _MARK:
        raise LingualError(f"{path} is an archive, but no Lingual trajectory: its array 'format' is missing.")
    for name, (kind, dimension) in _ARRAYS.items():
        array = arrays.get(name)
        if array is None or array.dtype.kind != kind or array.ndim != dimension:
            found = "missing" if array is None else f"{array.dtype} of dimension {array.ndim}"
            raise LingualError(f"{path}: the array '{name}' is {found}; write the trajectory again.")
    return arrays


NPZ_FORMAT = RecordingFormat("Lingual's npz", recognises, read)
