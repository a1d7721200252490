"""One entry for the rest of the program: any file with sensor motion, ready to be fitted to a mesh."""

from dataclasses import replace
from pathlib import Path

from ..model.trajectory import Trajectory
from .cleaning import clean
from .jaw_motion import remove_jaw_motion
from .recording_warning import warn
from .recordings import read_recording
from .smoothing import evenly_spaced, resample, smooth


def load_trajectory(path: Path | str, *, smoothed: bool = True, rate: float | None = None) -> Trajectory:
    """Reads a recording or a trajectory file: cleaned, filtered, in the jaw frame.

    A file in the jaw frame (ours only) is a finished trajectory: its drop-outs are bridged and nothing
    else is changed. smoothed: whether the filter of smoothing.py is applied to a file in the head frame.
    rate: frames a second of the result [Hz]; those of the file when None.

    What was repaired or assumed is told by RecordingWarnings. Raises LingualError for a file that cannot
    be used; the message names the file and the line or channel.
    """
    trajectory = clean(read_recording(path))
    if trajectory.frame == "head":
        trajectory = _jaw_relative(trajectory, smoothed)
    return trajectory if rate is None else resample(trajectory, rate)


def _jaw_relative(trajectory: Trajectory, smoothed: bool) -> Trajectory:
    """Filters first, so that the jaw's displacement is exactly zero in frame 0."""
    if smoothed:
        if not evenly_spaced(trajectory.time):
            even = trajectory.rate
            warn(trajectory.source, f"its frames are not evenly spaced; it is resampled to {even:.4g} Hz.")
            trajectory = resample(trajectory, even)
        trajectory = smooth(trajectory)
    if "LI" in trajectory.channels:
        return remove_jaw_motion(trajectory)
    warn(trajectory.source, "it has no jaw channel LI, so all motion is taken to be relative to the jaw.")
    return replace(trajectory, frame="jaw")
