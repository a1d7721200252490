"""Everything that ends in a Trajectory: recordings, filters, trajectory files."""

from .cleaning import clean
from .fitting import fit_to_sensors
from .jaw_motion import remove_jaw_motion
from .loading import load_trajectory
from .raw_recording import RawRecording
from .recording_warning import RecordingWarning
from .recordings import read_recording
from .smoothing import resample, smooth
from .trajectory_files import read_trajectory, write_trajectory

__all__ = [
    "RawRecording",
    "RecordingWarning",
    "clean",
    "fit_to_sensors",
    "load_trajectory",
    "read_recording",
    "read_trajectory",
    "remove_jaw_motion",
    "resample",
    "smooth",
    "write_trajectory",
]
