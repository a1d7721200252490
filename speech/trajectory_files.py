"""Lingual's own trajectory files, CSV and npz; docs/formats.md describes both for users.

Both round-trip bit for bit. The CSV is in millimetres for people: metres are shifted by three decimal
places as text (shortest text that gives back the same number, then Decimal), not multiplied by 1000,
which would round.
"""

import re
from pathlib import Path

from ..model.errors import LingualError
from ..model.trajectory import Trajectory
from .raw_recording import RawRecording
from .trajectory_csv import CSV_FORMAT, csv_text
from .trajectory_npz import NPZ_FORMAT, save_npz

__all__ = ["CSV_FORMAT", "NPZ_FORMAT", "as_trajectory", "read_trajectory", "write_trajectory"]

_CHANNEL_NAME = re.compile(r"[^\s,;\"#\x00-\x1f\x7f\ud800-\udfff]+")


def write_trajectory(path: Path | str, trajectory: Trajectory) -> None:
    """Writes a .csv or .npz file, by the path's ending.

    Raises LingualError for another ending, a channel name that a CSV header cannot hold, or a file that
    cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() not in (".csv", ".npz"):
        raise LingualError(f"{path}: a trajectory is written as .csv or .npz; give it one of these endings.")
    for name in trajectory.channels:
        if not _CHANNEL_NAME.fullmatch(name) or name == "jaw":
            raise LingualError(
                f"{path}: a trajectory file cannot hold a channel called '{name}'; rename it "
                "(no blanks, commas, semicolons, quotes or #, and not 'jaw')."
            )
    try:
        if path.suffix.lower() == ".csv":
            path.write_text(csv_text(trajectory), encoding="utf-8")
        else:
            save_npz(path, trajectory)
    except OSError as error:
        raise LingualError(f"{path} cannot be written ({error.strerror or error}).") from error


def read_trajectory(path: Path | str) -> Trajectory:
    """Reads what write_trajectory wrote, or a CSV of the same form made elsewhere.

    The trajectory's source is the path. Raises LingualError, naming line and column (CSV) or array (npz),
    for a malformed file, and, naming channel and frame, for a missing sample: recordings with drop-outs
    are for load_trajectory, which bridges them.
    """
    path = Path(path)
    if path.suffix.lower() not in (".csv", ".npz"):
        raise LingualError(f"{path}: a trajectory file ends in .csv or .npz.")
    return as_trajectory((NPZ_FORMAT if path.suffix.lower() == ".npz" else CSV_FORMAT).read(path))


def as_trajectory(raw: RawRecording) -> Trajectory:
    """A recording without missing samples as a Trajectory. Raises LingualError, naming a missing one."""
    return Trajectory(
        time=raw.time,
        channels=raw.channels,
        positions=raw.positions,
        measured=raw.measured,
        frame=raw.frame,
        jaw_translation=raw.jaw_translation,
        source=raw.source,
    )
