"""Stages that do not need each other, side by side on CUDA: two streams of one graph."""

import warp as wp

from ..model.dense_product import Stage


class ParallelStages:
    """Runs `first` and `second`, in this order on a CPU and beside each other on CUDA. Itself a stage.

    Neither may read what the other writes.
    """

    def __init__(self, first: list[Stage], second: list[Stage], device: str) -> None:
        self._first, self._second = first, second
        self._device = wp.get_device(device)
        self._stream = None if self._device.is_cpu else wp.Stream(self._device)

    def __call__(self) -> None:
        if self._stream is None or not self._second:
            for stage in self._first + self._second:
                stage()
            return
        with wp.ScopedStream(self._stream):  # waits for what has been launched so far
            for stage in self._second:
                stage()
            finished = self._stream.record_event()
        for stage in self._first:
            stage()
        wp.get_stream(self._device).wait_event(finished)
