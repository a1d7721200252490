"""Which samples of a recording are not positions of the coil: drop-outs, jumps and spikes.

A sample is lost when
- it is not a number, farther than FIELD from the origin (systems write huge values, X-ray microbeam 1e6,
  for "missing"), or exactly zero in every measured coordinate where the coil cannot have come to the origin;
- the coil would have had to move faster than SPEED_LIMIT to get there. The recordings this was made with
  peak at 0.19 m/s (Luo's three sentences) and 0.30 m/s (a sentence of HPRC), so 1 m/s leaves a factor of 3;
- it stands out from the line between its neighbours by more than an acceleration of ACCELERATION_LIMIT
  explains and by more than SPIKE_SIGMAS robust standard deviations of that distance in the channel. The
  same recordings peak at 29 m/s^2.

A jump that lasts is no lost sample but a coil that came loose or was glued on again: it is refused.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model.errors import LingualError
from ..model.units import MM_PER_M

FIELD = 1.0
"""Distance from the origin that no coil has [m]: measuring volumes are half a metre across at most."""

SPEED_LIMIT = 1.0
"""Speed that no articulator reaches in speech [m/s]."""

ACCELERATION_LIMIT = 60.0
"""Acceleration that no articulator reaches in speech [m/s^2]."""

SPIKE_SIGMAS = 10.0

SMALLEST_SPIKE = 0.5e-3
"""Deviation that is left to the smoothing filter [m]: about the accuracy of articulographs."""

LASTING_JUMP = 0.25
"""A jump that does not return within this time is no spike [s]."""

_SPIKE_PASSES = 4  # each takes off the outermost samples of a spike that is several frames wide


@dataclass(frozen=True)
class LostSamples:
    """Masks over the frames of one channel, (frame_count,) bool each.

    missing: the file has no position; jumped: it has one where the coil cannot have been.
    """

    missing: NDArray[np.bool_]
    jumped: NDArray[np.bool_]

    @property
    def lost(self) -> NDArray[np.bool_]:
        return self.missing | self.jumped


def find_lost_samples(
    time: NDArray[np.float64], positions: NDArray[np.float64], source: str, channel: str
) -> LostSamples:
    """Finds the lost samples of one channel.

    time: (frame_count,) [s]; positions: (frame_count, d) [m], the d measured coordinates.

    Raises LingualError, naming the channel and the time, for a jump that lasts.
    """
    missing = _missing(time, positions)
    jumped = _too_fast(time, positions, missing, source, channel)
    for _ in range(_SPIKE_PASSES):
        spikes = _spikes(time, positions, np.flatnonzero(~(missing | jumped)))
        if len(spikes) == 0:
            break
        jumped[spikes] = True
    return LostSamples(missing, jumped)


def _missing(time: NDArray[np.float64], positions: NDArray[np.float64]) -> NDArray[np.bool_]:
    with np.errstate(invalid="ignore"):
        outside = np.asarray(~(np.abs(positions) < FIELD).all(axis=1))  # also true for NaN
    return outside | _false_zeros(time, positions, outside)


def _false_zeros(
    time: NDArray[np.float64], positions: NDArray[np.float64], outside: NDArray[np.bool_]
) -> NDArray[np.bool_]:
    """Zeros that stand for "missing": the coil cannot have got to the origin from the samples around them."""
    zero = (positions == 0.0).all(axis=1)
    false = np.zeros_like(zero)
    elsewhere = np.flatnonzero(~zero & ~outside)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], zero, [False]])))
    for start, end in edges.reshape(-1, 2):
        i = int(np.searchsorted(elsewhere, start))
        for frame, neighbour in ((start, elsewhere[i - 1 : i]), (end - 1, elsewhere[i : i + 1])):
            distance = np.linalg.norm(positions[neighbour], axis=1)
            if np.any(distance > SPEED_LIMIT * np.abs(time[neighbour] - time[frame])):
                false[start:end] = True
    return false


def _too_fast(
    time: NDArray[np.float64],
    positions: NDArray[np.float64],
    missing: NDArray[np.bool_],
    source: str,
    channel: str,
) -> NDArray[np.bool_]:
    """Stretches that only a jump reaches from the longest unbroken stretch, outward from it on both sides."""
    jumped = np.zeros(len(time), dtype=bool)
    good = np.flatnonzero(~missing)
    if len(good) < 2:
        return jumped
    distance = np.linalg.norm(np.diff(positions[good], axis=0), axis=1)
    stretches = np.split(good, np.flatnonzero(distance > SPEED_LIMIT * np.diff(time[good])) + 1)
    longest = int(np.argmax([len(stretch) for stretch in stretches]))
    for direction, end in ((1, -1), (-1, 0)):
        last = stretches[longest][end]
        for stretch in stretches[longest + 1 :] if direction > 0 else stretches[:longest][::-1]:
            first = stretch[0] if direction > 0 else stretch[-1]
            moved = float(np.linalg.norm(positions[first] - positions[last]))
            if moved <= SPEED_LIMIT * abs(time[first] - time[last]):
                last = stretch[end]
            elif time[stretch[-1]] - time[stretch[0]] > LASTING_JUMP:
                at = time[first if direction > 0 else last]
                raise LingualError(
                    f"{source}: channel {channel} jumps by {moved * MM_PER_M:.0f} mm at {at:.2f} s and stays "
                    "there: the coil came loose or was moved; use the part of the recording before or after."
                )
            else:
                jumped[stretch] = True
    return jumped


def _spikes(
    time: NDArray[np.float64], positions: NDArray[np.float64], good: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Frames among `good` that stand out from the line between their neighbours more than speech explains."""
    if len(good) < 5:
        return good[:0]
    t, x = time[good], positions[good]
    before, after = t[1:-1] - t[:-2], t[2:] - t[1:-1]
    share = (before / (before + after))[:, None]
    deviation = np.linalg.norm(x[1:-1] - (1.0 - share) * x[:-2] - share * x[2:], axis=1)
    explained = 0.5 * ACCELERATION_LIMIT * before * after
    threshold = np.maximum(explained, max(SMALLEST_SPIKE, SPIKE_SIGMAS * 1.4826 * np.median(deviation)))
    padded = np.concatenate([[0.0], deviation, [0.0]])
    peak = (deviation >= padded[:-2]) & (deviation >= padded[2:])
    return good[1:-1][peak & (deviation > threshold)]
