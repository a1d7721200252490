"""From a recording with its flaws to a Trajectory: units checked, lost samples bridged or refused.

Lost samples (lost_samples.py) are bridged by PCHIP, a cubic interpolation that makes no overshoot (Fritsch
and Carlson 1980), coordinate by coordinate; at the ends of the recording the nearest position is held. A
bridge is a guess, so a channel that the simulation needs is refused when a gap exceeds LONGEST_GAP, about a
syllable, or when more than LARGEST_SHARE of it is lost. Another channel is then left out.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from ..model.errors import LingualError
from ..model.sensors import SENSOR_NAMES
from ..model.trajectory import Trajectory
from ..model.units import MM_PER_M
from .lost_samples import LostSamples, find_lost_samples
from .raw_recording import RawRecording
from .recording_warning import warn

LONGEST_GAP = 0.25
"""Longest stretch that is bridged [s]."""

LARGEST_SHARE = 0.25
"""Largest share of a channel's samples that is bridged."""

NEEDED_CHANNELS = (*SENSOR_NAMES, "LI")
"""Tongue and jaw: a channel among these is refused where another one is left out."""

# Extent of all channels together [m] that a vocal tract can have: from a channel moving by a centimetre to
# a head with reference coils on the ears.
_SMALLEST_EXTENT, _LARGEST_EXTENT = 0.008, 0.6


def clean(raw: RawRecording, needed: tuple[str, ...] = NEEDED_CHANNELS) -> Trajectory:
    """The recording as a Trajectory: every measured coordinate of every channel is a number.

    needed: channels that must survive, where the recording has them. Bridged samples are counted in one
    RecordingWarning a channel.

    Raises LingualError when the values cannot be millimetres, or when a needed channel has lost too much.
    """
    _check_times(raw)
    check_unit(raw)
    kept: list[int] = []
    positions = raw.positions.copy()
    for c, name in enumerate(raw.channels):
        axes = np.flatnonzero(raw.measured[c])
        if len(axes) == 0:
            kept.append(c)
            continue
        lost = find_lost_samples(raw.time, raw.positions[:, c, axes], raw.source, name)
        refusal = _refusal(raw.time, lost)
        if refusal and name in needed:
            raise LingualError(f"{raw.source}: channel {name} {refusal}; use another part of the recording.")
        if refusal:
            warn(raw.source, f"channel {name} {refusal}; it is left out.")
            continue
        kept.append(c)
        if lost.lost.any():
            positions[:, c, axes] = bridge(raw.time, raw.positions[:, c, axes], lost.lost)
            warn(raw.source, _account(raw.time, name, lost))
    if not kept:
        raise LingualError(f"{raw.source}: no channel has enough samples to be used.")
    return Trajectory(
        time=raw.time,
        channels=tuple(raw.channels[c] for c in kept),
        positions=positions[:, kept],
        measured=raw.measured[kept],
        frame=raw.frame,
        jaw_translation=raw.jaw_translation,
        source=raw.source,
    )


def bridge(
    time: NDArray[np.float64], positions: NDArray[np.float64], lost: NDArray[np.bool_]
) -> NDArray[np.float64]:
    """Positions (frame_count, d) [m] with the lost frames (frame_count,) interpolated from the others."""
    good = np.flatnonzero(~lost)
    bridged = positions.copy()
    if len(good) == 1:
        bridged[:] = positions[good[0]]
        return bridged
    inside = np.clip(time[lost], time[good[0]], time[good[-1]])
    bridged[lost] = PchipInterpolator(time[good], positions[good], axis=0)(inside)
    return bridged


def check_unit(raw: RawRecording) -> None:
    """Refuses an extent that no vocal tract has: metres, 1/100 mm or normalised values taken for mm.

    The extent is that from the 5th to the 95th percentile of all channels together, in the widest
    direction, so a few wild values do not matter. A single channel may be small: it may just be still.
    """
    values = np.where(raw.measured, raw.positions, np.nan).reshape(-1, 3)
    values = values[:, raw.measured.any(axis=0)]
    finite = [column[np.isfinite(column)] for column in values.T]
    extents = [float(np.subtract(*np.percentile(c, [95.0, 5.0]))) for c in finite if len(c)]
    extent = max(extents, default=0.0)
    still = len(raw.channels) == 1 and extent < _SMALLEST_EXTENT
    if not extents or still or _SMALLEST_EXTENT <= extent <= _LARGEST_EXTENT:
        return
    remedy = "scale them to millimetres"
    for factor, unit in ((1000.0, "metres"), (0.01, "1/100 mm"), (0.001, "micrometres")):
        if 0.02 <= extent * factor <= 0.25:
            remedy = f"they look like {unit}: multiply them by {factor:g}"
            break
    raise LingualError(
        f"{raw.source}: read as millimetres its channels extend over {extent * MM_PER_M:.3g} mm, which no "
        f"mouth does; {remedy}."
    )


def _check_times(raw: RawRecording) -> None:
    if not np.isfinite(raw.time).all() or np.any(np.diff(raw.time) <= 0.0):
        raise LingualError(f"{raw.source}: the times do not increase strictly: sort or repair them.")


def _refusal(time: NDArray[np.float64], lost: LostSamples) -> str:
    """Why a channel has lost too much to be bridged, continuing "channel X ..."; empty when it has not."""
    share = float(lost.lost.mean())
    if share == 1.0:
        return "has no valid sample"
    if share > LARGEST_SHARE:
        return f"has lost {share:.0%} of its samples, and at most {LARGEST_SHARE:.0%} are bridged"
    start, length = _longest_gap(time, lost.lost)
    if length > LONGEST_GAP:
        return f"is lost for {length:.2f} s from {start:.2f} s on; at most {LONGEST_GAP} s are bridged"
    return ""


def _account(time: NDArray[np.float64], name: str, lost: LostSamples) -> str:
    _, length = _longest_gap(time, lost.lost)
    kinds = [
        f"{count} {kind}"
        for count, kind in ((int(lost.missing.sum()), "missing"), (int(lost.jumped.sum()), "jumping"))
        if count
    ]
    return (
        f"channel {name} has {' and '.join(kinds)} of {len(time)} samples; they are bridged, "
        f"the longest gap is {length * 1000:.0f} ms."
    )


def _longest_gap(time: NDArray[np.float64], lost: NDArray[np.bool_]) -> tuple[float, float]:
    """Start and length [s] of the longest stretch of lost frames; each frame lasts until the next."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], lost, [False]])))
    if len(edges) == 0:
        return 0.0, 0.0
    step = float(np.median(np.diff(time))) if len(time) > 1 else 0.0
    ends = np.append(time, time[-1] + step)
    starts, lengths = time[edges[::2]], ends[edges[1::2]] - time[edges[::2]]
    longest = int(np.argmax(lengths))
    return float(starts[longest]), float(lengths[longest])
