"""Average volume change of the tongue in every syllable (Yang 2013, Fig. 5).

The change of one production of a syllable is the mean over its frames of |V / V0 - 1|, V being the volume of the
deformed mesh and V0 that at rest; a syllable's is the mean over its productions. The paper does not say whether it
averages magnitudes; signed changes would cancel, so magnitudes are taken here.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from ..model import LingualError, StateHistory


@dataclass(frozen=True)
class LabelledInterval:
    """One production of something: label, e.g. "ta"; start and end [s], both included."""

    label: str
    start: float
    end: float


@dataclass(frozen=True)
class VolumeChange:
    """Volume change of one syllable, as fractions of the rest volume.

    mean: over its productions of their mean magnitude. largest: magnitude of any frame of any production.
    production_count: how many there are.
    """

    mean: float
    largest: float
    production_count: int


def volume_change_per_label(history: StateHistory, intervals: Iterable[LabelledInterval]) -> dict[str, VolumeChange]:
    """Volume change of every label, in the order of first occurrence, from the history's "volume_ratio".

    Raises LingualError for an interval in which the history has no frame.
    """
    change = np.abs(history.scalar("volume_ratio") - 1.0)
    productions: dict[str, list[np.ndarray]] = {}
    for interval in intervals:
        inside = change[(history.time >= interval.start) & (history.time <= interval.end)]
        if len(inside) == 0:
            raise LingualError(
                f"No frame was simulated in '{interval.label}' from {interval.start:g} s to {interval.end:g} s: "
                "give intervals within the recording."
            )
        productions.setdefault(interval.label, []).append(inside)
    return {
        label: VolumeChange(
            mean=float(np.mean([frames.mean() for frames in of_label])),
            largest=float(max(frames.max() for frames in of_label)),
            production_count=len(of_label),
        )
        for label, of_label in productions.items()
    }
