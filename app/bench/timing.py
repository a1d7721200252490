"""Wall-clock times of repeated work, on the host or on a CUDA device."""

import time
from collections.abc import Callable

import numpy as np
import warp as wp


def median_ms(work: Callable[[], object], repetitions: int, warm_up: int = 2, device: str = "cpu") -> float:
    """Median time of one call [ms], after some that are not counted."""
    for _ in range(warm_up):
        work()
    wp.synchronize_device(device)
    times = []
    for _ in range(repetitions):
        started = time.perf_counter()
        work()
        wp.synchronize_device(device)
        times.append(time.perf_counter() - started)
    return 1e3 * float(np.median(times))


def median_over_frames_ms(
    advance: Callable[[int], object], frame_count: int, warm_up: int, device: str = "cpu"
) -> float:
    """Median time [ms] of advance(0), advance(1), ..., of which the first `warm_up` are not counted."""
    times = []
    for frame in range(frame_count):
        started = time.perf_counter()
        advance(frame)
        wp.synchronize_device(device)
        times.append(time.perf_counter() - started)
    return 1e3 * float(np.median(times[warm_up:]))
