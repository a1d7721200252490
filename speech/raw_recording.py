"""A recording as its file has it, drop-outs included; cleaning turns it into a Trajectory."""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..model.errors import LingualError


@dataclass(frozen=True, eq=False)
class RawRecording:
    """What a reader makes of one file, in SI units and axes (x anterior, y left, z up).

    time: (frame_count,) float64 [s].
    channels: names, e.g. ("TT", "TB", "TD", "TR", "LI", "UL", "LL").
    positions: (frame_count, channel_count, 3) float64 [m]; NaN where not measured, and where the coil
        was lost or the file holds no number.
    measured: (channel_count, 3) bool: which coordinates the recording has at all.
    frame: "head", or "jaw" when the file says that jaw motion has been removed.
    jaw_translation: (frame_count, 3) float64 [m]: displacement of the jaw in the head frame, when the
        file gives it; zeros otherwise.
    source: the file, for messages.

    Raises LingualError, naming the source, for shapes that do not agree or no frame at all.
    """

    time: NDArray[np.float64]
    channels: tuple[str, ...]
    positions: NDArray[np.float64]
    measured: NDArray[np.bool_]
    source: str
    frame: str = "head"
    jaw_translation: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))

    def __post_init__(self) -> None:
        shape = (len(self.time), len(self.channels), 3)
        if self.jaw_translation.size == 0:
            object.__setattr__(self, "jaw_translation", np.zeros((shape[0], 3)))
        if shape[0] < 1 or shape[1] < 1:
            raise LingualError(f"{self.source} holds {shape[0]} frames of {shape[1]} channels: it is empty.")
        if self.positions.shape != shape or self.measured.shape != shape[1:]:
            raise LingualError(
                f"{self.source}: positions have shape {self.positions.shape}, {shape} is needed."
            )
        if self.jaw_translation.shape != (shape[0], 3):
            raise LingualError(
                f"{self.source}: the jaw has {len(self.jaw_translation)} frames, not {shape[0]}."
            )


@dataclass(frozen=True)
class RecordingFormat:
    """A kind of file that holds sensor motion.

    name: how messages call it. recognises: whether a file is of this kind, from its path and its first
    bytes; content decides, the name only where formats have no mark of their own. read: the whole file;
    it raises LingualError, naming the line or the channel, for anything that it cannot use.
    """

    name: str
    recognises: Callable[[Path, bytes], bool]
    read: Callable[[Path], RawRecording]
