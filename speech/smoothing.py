"""Savitzky-Golay filter and change of rate.

The filter replaces every sample by the value there of the polynomial of third order fitted by least squares
to the 21 samples around it (Luo 2017, section 4, at 100 Hz). In the first and last 10 frames the polynomial
of the first and last 21 frames is evaluated. So cubic motion passes unchanged everywhere, ends included.
"""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator
from scipy.signal import savgol_filter

from ..model.errors import LingualError
from ..model.trajectory import Trajectory
from .recording_warning import warn

ORDER = 3
HALF_WINDOW = 0.1
"""Half the width of the filter [s]: 10 frames at 100 Hz."""

_MOST_FRAMES = 10_000_000


def smoothing_window(rate: float) -> int:
    """Frames of the filter at a rate [Hz]: 21 at 100 Hz, as many seconds at others; at least 5."""
    return max(2 * round(HALF_WINDOW * rate) + 1, ORDER + 2)


def smooth(trajectory: Trajectory, window: int | None = None) -> Trajectory:
    """The trajectory filtered in every measured coordinate and in jaw_translation.

    window: frames, odd, at least 5; smoothing_window(rate) when None. A shorter trajectory is filtered
    with the longest window that fits, with a RecordingWarning; one of less than 5 frames is not filtered.

    Raises LingualError for another window, or when the frames are not evenly spaced in time.
    """
    width = smoothing_window(trajectory.rate) if window is None else window
    if width < ORDER + 2 or width % 2 == 0:
        raise LingualError(f"The smoothing window is {width} frames; it must be odd and {ORDER + 2} or more.")
    if trajectory.frame_count < width:
        fitting = trajectory.frame_count - 1 + trajectory.frame_count % 2
        if fitting < ORDER + 2:
            warn(trajectory.source, f"its {trajectory.frame_count} frames are too few to be filtered.")
            return trajectory
        warn(
            trajectory.source,
            f"it has {trajectory.frame_count} frames, so the filter's window is {fitting}, not {width}.",
        )
        width = fitting
    if not evenly_spaced(trajectory.time):
        raise LingualError(f"{trajectory.source}: the frames are not evenly spaced in time; resample first.")
    positions = trajectory.positions.copy()
    positions[:, trajectory.measured] = _filtered(positions[:, trajectory.measured], width)
    return replace(
        trajectory, positions=positions, jaw_translation=_filtered(trajectory.jaw_translation, width)
    )


def _filtered(values: NDArray[np.float64], width: int) -> NDArray[np.float64]:
    """Values (frame_count, k) filtered along the first axis."""
    return savgol_filter(values, width, ORDER, axis=0, mode="interp")


def evenly_spaced(time: NDArray[np.float64]) -> bool:
    """Whether all steps of time (frame_count,) are within 1 % of their mean."""
    steps = np.diff(time)
    return len(steps) == 0 or bool(np.abs(steps - steps.mean()).max() <= 0.01 * steps.mean())


def resample(trajectory: Trajectory, rate: float) -> Trajectory:
    """The trajectory at `rate` frames a second [Hz], from its first time on.

    Shape-preserving cubic interpolation (PCHIP). Filter before lowering the rate: nothing is done here
    against aliasing. Coordinates with values in some frames only, which are not measured, become NaN.
    A trajectory that has these times already comes back as it is.

    Raises LingualError for a rate that is not positive or gives more than ten million frames.
    """
    if not (np.isfinite(rate) and rate > 0.0):
        raise LingualError(f"The rate is {rate} Hz; it must be positive.")
    if trajectory.duration * rate > _MOST_FRAMES:
        raise LingualError(
            f"{trajectory.source}: {trajectory.duration:.3g} s at {rate:g} Hz are too many frames."
        )
    if trajectory.frame_count < 2:
        return trajectory
    old = trajectory.time
    count = int(np.floor(trajectory.duration * rate + 1e-6)) + 1
    time = old[0] + np.arange(count) / rate
    if count == len(old) and np.abs(time - old).max() < 1e-6 / rate:
        return trajectory
    inside = np.clip(time, old[0], old[-1])
    whole = np.isfinite(trajectory.positions).all(axis=0)
    positions = np.full((count, *whole.shape), np.nan)
    positions[:, whole] = PchipInterpolator(old, trajectory.positions[:, whole], axis=0)(inside)
    jaw = PchipInterpolator(old, trajectory.jaw_translation, axis=0)(inside)
    return replace(trajectory, time=time, positions=positions, jaw_translation=jaw)
