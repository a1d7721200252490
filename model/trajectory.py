"""Motion of sensors over time: the one type in which every source of speech ends."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from .errors import LingualError


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Positions of named channels at increasing times.

    time: (frame_count,) float64 [s], strictly increasing.
    channels: names, e.g. ("TT", "TB", "TD", "TR", "LI", "UL", "LL").
    positions: (frame_count, channel_count, 3) float64 [m]; NaN in a coordinate that was not recorded.
    measured: (channel_count, 3) bool: which coordinates the recording has. A channel recorded in two
        dimensions constrains two coordinates, not three.
    frame: "head" or "jaw" (jaw motion removed).
    jaw_translation: (frame_count, 3) float64 [m]: displacement of the jaw in the head frame relative to
        the reference frame; zeros when unknown.
    source: file or text that it came from, for messages.

    Raises LingualError, naming the source, for shapes that do not agree, times that do not increase or
    values that are not finite in a measured coordinate.
    """

    time: NDArray[np.float64]
    channels: tuple[str, ...]
    positions: NDArray[np.float64]
    measured: NDArray[np.bool_]
    frame: str = "head"
    jaw_translation: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 3)))
    source: str = "trajectory"

    def __post_init__(self) -> None:
        if self.jaw_translation.size == 0:
            object.__setattr__(self, "jaw_translation", np.zeros((len(self.time), 3)))
        self._check()

    def _check(self) -> None:
        shape = (len(self.time), len(self.channels), 3)
        if self.positions.shape != shape or self.measured.shape != shape[1:]:
            raise LingualError(f"{self.source}: positions have shape {self.positions.shape}, {shape} is needed.")
        if self.jaw_translation.shape != (shape[0], 3):
            raise LingualError(f"{self.source}: the jaw has {len(self.jaw_translation)} frames, not {shape[0]}.")
        if self.frame not in ("head", "jaw"):
            raise LingualError(f"{self.source}: the frame is '{self.frame}'; it must be 'head' or 'jaw'.")
        if shape[0] < 1:
            raise LingualError(f"{self.source}: the trajectory has no frame.")
        if len(set(self.channels)) < len(self.channels):
            raise LingualError(f"{self.source}: a channel name appears twice in {', '.join(self.channels)}.")
        if not np.isfinite(self.time).all() or np.any(np.diff(self.time) <= 0.0):
            raise LingualError(f"{self.source}: the times do not increase strictly.")
        bad = np.argwhere(~np.isfinite(self.positions) & self.measured)
        if len(bad):
            frame, channel, axis = bad[0]
            raise LingualError(
                f"{self.source}: channel {self.channels[channel]} {'xyz'[axis]} is not finite at frame {frame}; "
                "bridge drop-outs before building a Trajectory."
            )

    @property
    def frame_count(self) -> int:
        return len(self.time)

    @property
    def duration(self) -> float:
        """Time from the first to the last frame [s]."""
        return float(self.time[-1] - self.time[0])

    @property
    def rate(self) -> float:
        """Mean frames a second [Hz]; 0 for a single frame."""
        return (self.frame_count - 1) / self.duration if self.frame_count > 1 else 0.0

    def channel_index(self, name: str) -> int:
        """Index of channel `name`. Raises LingualError, listing what there is, when it is absent."""
        if name not in self.channels:
            raise LingualError(f"{self.source}: there is no channel {name}; it has {', '.join(self.channels)}.")
        return self.channels.index(name)

    def select(self, names: tuple[str, ...]) -> "Trajectory":
        """The same motion with the named channels only, in that order."""
        index = [self.channel_index(name) for name in names]
        return replace(
            self, channels=tuple(names), positions=self.positions[:, index], measured=self.measured[index]
        )

    def head(self, frame_count: int) -> "Trajectory":
        """The first `frame_count` frames."""
        return replace(
            self,
            time=self.time[:frame_count],
            positions=self.positions[:frame_count],
            jaw_translation=self.jaw_translation[:frame_count],
        )
