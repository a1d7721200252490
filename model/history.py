"""What has been simulated so far: random access in time for display, plots and export."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Sample:
    """The history read at one time, interpolated linearly between frames.

    time [s]; nodes: (node_count, 3) float32 [m], jaw frame; sensors and sensor_targets:
    (sensor_count, 3) [m], jaw frame; jaw_translation: (3,) [m].
    """

    time: float
    nodes: NDArray[np.float32]
    sensors: NDArray[np.float64]
    sensor_targets: NDArray[np.float64]
    jaw_translation: NDArray[np.float64]


class StateHistory:
    """Frames appended by one thread (the simulation) and read by others (display).

    A frame becomes visible to readers when `frame_count` is advanced, after its data are in place;
    frames are never changed afterwards, so no lock is needed.

    node_count, sensor_count: sizes of a frame. capacity: frames reserved at first; it doubles when full.
    """

    def __init__(self, node_count: int, sensor_count: int, capacity: int = 256) -> None:
        self.frame_count = 0
        self._time = np.empty(capacity)
        self._nodes = np.empty((capacity, node_count, 3), dtype=np.float32)
        self._sensors = np.empty((capacity, 2, sensor_count, 3))
        self._jaw = np.empty((capacity, 3))
        self._scalars: dict[str, NDArray[np.float64]] = {}

    def append(
        self,
        time: float,
        nodes: NDArray[np.floating],
        sensors: NDArray[np.floating],
        sensor_targets: NDArray[np.floating],
        jaw_translation: NDArray[np.floating],
        **scalars: float,
    ) -> None:
        """Adds a frame later than the last. `scalars`: named values of the frame (step time, volume, ...)."""
        if self.frame_count and time <= self._time[self.frame_count - 1]:
            raise ValueError(f"frame at {time} s is not later than {self._time[self.frame_count - 1]} s")
        if self.frame_count == len(self._time):
            self._grow()
        i = self.frame_count
        self._time[i] = time
        self._nodes[i] = nodes
        self._sensors[i, 0] = sensors
        self._sensors[i, 1] = sensor_targets
        self._jaw[i] = jaw_translation
        for name, value in scalars.items():
            if name not in self._scalars:
                self._scalars[name] = np.full(len(self._time), np.nan)
            self._scalars[name][i] = value
        self.frame_count = i + 1

    def _grow(self) -> None:
        def doubled(a: NDArray) -> NDArray:
            b = np.full((2 * len(a), *a.shape[1:]), np.nan, dtype=a.dtype)
            b[: len(a)] = a
            return b

        self._time, self._nodes = doubled(self._time), doubled(self._nodes)
        self._sensors, self._jaw = doubled(self._sensors), doubled(self._jaw)
        self._scalars = {name: doubled(a) for name, a in self._scalars.items()}

    @property
    def time(self) -> NDArray[np.float64]:
        """Times of the frames so far [s], (frame_count,)."""
        return self._time[: self.frame_count]

    @property
    def sensors(self) -> NDArray[np.float64]:
        """Sensor positions of the frames so far [m], (frame_count, sensor_count, 3), jaw frame."""
        return self._sensors[: self.frame_count, 0]

    def scalar(self, name: str) -> NDArray[np.float64]:
        """A named value over the frames so far, (frame_count,); NaN where a frame did not give it."""
        count = self.frame_count
        return self._scalars[name][:count] if name in self._scalars else np.full(count, np.nan)

    @property
    def scalar_names(self) -> tuple[str, ...]:
        return tuple(self._scalars)

    def sample(self, time: float) -> Sample:
        """The history at `time`, clamped to what has been simulated. There must be at least one frame."""
        count = self.frame_count
        times = self._time[:count]
        time = float(np.clip(time, times[0], times[-1]))
        hi = int(np.searchsorted(times, time))
        lo = max(hi - 1, 0)
        t = 0.0 if hi == lo else (time - times[lo]) / (times[hi] - times[lo])
        nodes, sensors, jaw = self._nodes, self._sensors, self._jaw
        both = (1.0 - t) * sensors[lo] + t * sensors[hi]
        return Sample(
            time=time,
            nodes=nodes[lo] + np.float32(t) * (nodes[hi] - nodes[lo]),
            sensors=both[0],
            sensor_targets=both[1],
            jaw_translation=(1.0 - t) * jaw[lo] + t * jaw[hi],
        )
