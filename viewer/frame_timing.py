"""How long pictures take, over the last few seconds."""

from collections import deque

import numpy as np

_KEPT = 180


class FrameTiming:
    """Durations of the last pictures: `work`, what the program did, and the interval to the next one."""

    def __init__(self) -> None:
        self._work: deque[float] = deque(maxlen=_KEPT)
        self._interval: deque[float] = deque(maxlen=_KEPT)

    def add(self, work: float, interval: float) -> None:
        """Records a picture; both in seconds."""
        self._work.append(1e3 * work)
        self._interval.append(1e3 * interval)

    @property
    def work(self) -> list[float]:
        """Work per picture [ms], oldest first."""
        return list(self._work)

    @property
    def work_median(self) -> float:
        """Typical work per picture [ms]; 0 before the first."""
        return float(np.median(self._work)) if self._work else 0.0

    @property
    def frames_per_second(self) -> float:
        """Pictures shown per second."""
        mean = float(np.mean(self._interval)) if self._interval else 0.0
        return 1e3 / mean if mean > 0.0 else 0.0
