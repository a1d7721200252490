"""The coils' motion so far, thinned for plotting and read from the history as it grows."""

import numpy as np
from numpy.typing import NDArray

from ..model import StateHistory

_POINTS = 240  # over the whole trajectory
_READ_AT_ONCE = 24  # samples read per call: a long history is caught up with over a few pictures


class SensorTrack:
    """Positions of the coils at evenly spaced times.

    duration: of the trajectory [s].
    """

    def __init__(self, sensor_count: int, duration: float) -> None:
        self._interval = max(duration / _POINTS, 0.01)
        capacity = int(duration / self._interval) + 2
        self._time = np.zeros(capacity)
        self._positions = np.zeros((capacity, sensor_count, 3))
        self._count = 0

    def update(self, history: StateHistory) -> None:
        """Reads what has been simulated since the last call."""
        if history.frame_count == 0:
            return
        frontier = history.time[-1]
        for _ in range(_READ_AT_ONCE):
            time = self._count * self._interval
            if self._count == len(self._time) or time > frontier:
                return
            self._time[self._count] = time
            self._positions[self._count] = history.sample(time).sensors
            self._count += 1

    @property
    def time(self) -> NDArray[np.float64]:
        """Times read so far [s], (count,)."""
        return self._time[: self._count]

    @property
    def positions(self) -> NDArray[np.float64]:
        """Positions then [m], (count, sensor_count, 3), jaw frame."""
        return self._positions[: self._count]
