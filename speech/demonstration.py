"""The built-in demonstration: "ta ka la, i u a", as postures of the four coils on the head of our own.

A score of postures is joined by minimum-jerk movements (Flash and Hogan 1985). The displacements are
chosen for our own head so that /t/ and /l/ bring the tip to the alveolar ridge and /k/ the dorsum to the
palate; they are not measurements. Measured and synthesised speech come through recordings and text.
"""

import numpy as np
from numpy.typing import NDArray

from ..model.tongue_model import TongueModel
from ..model.trajectory import Trajectory
from ..model.units import M_PER_MM

RATE = 100.0
"""Frames a second [Hz]."""

# Displacement from rest in the jaw frame, (x, z) [mm] of TT, TB, TD, TR, then the jaw's own in the head.
_POSTURES: dict[str, list[tuple[float, float]]] = {
    "rest": [(0, 0), (0, 0), (0, 0), (0, 0), (0, 0)],
    "a": [(-3.0, -1.5), (-4.0, -3.5), (-5.0, -4.0), (-4.5, -1.5), (-1.0, -6.0)],
    "t": [(2.5, 8.5), (0.5, 4.0), (-1.5, 0.5), (-1.0, 0.0), (0.0, -1.0)],
    "k": [(-5.0, -2.0), (-3.0, 4.0), (-1.0, 10.0), (1.0, 7.0), (-0.5, -2.0)],
    "l": [(2.5, 8.5), (-1.5, 0.0), (-3.0, -1.0), (-2.5, 0.5), (-0.3, -2.0)],
    "i": [(2.0, 3.0), (4.0, 8.0), (5.0, 7.0), (6.0, 2.5), (0.0, -1.0)],
    "u": [(-7.0, -1.0), (-5.5, 1.5), (-4.0, 6.0), (-3.5, 4.5), (0.0, -1.5)],
}

# Posture, time to reach it [s], time to hold it [s].
_SCORE: list[tuple[str, float, float]] = [
    ("rest", 0.0, 0.15),
    *[("t", 0.14, 0.05), ("a", 0.18, 0.12)],
    *[("k", 0.16, 0.06), ("a", 0.18, 0.12)],
    *[("l", 0.16, 0.07), ("a", 0.18, 0.16)],
    *[("i", 0.22, 0.22), ("u", 0.26, 0.22), ("a", 0.24, 0.22)],
    ("rest", 0.30, 0.25),
]


def demonstration(tongue: TongueModel) -> Trajectory:
    """Targets for the tongue's sensors, jaw frame, with the jaw's motion; x and z are imposed.

    Raises KeyError when the tongue lacks one of the four sensors.
    """
    postures = {name: M_PER_MM * np.array(table, dtype=np.float64) for name, table in _POSTURES.items()}
    frames = _perform([(postures[name], reach, hold) for name, reach, hold in _SCORE])
    order = [("TT", "TB", "TD", "TR").index(name) for name in tongue.sensors.names]
    displacement = np.zeros((len(frames), len(order), 3))
    displacement[:, :, [0, 2]] = frames[:, order]
    jaw = np.zeros((len(frames), 3))
    jaw[:, [0, 2]] = frames[:, 4]
    return Trajectory(
        time=np.arange(len(frames)) / RATE,
        channels=tongue.sensors.names,
        positions=tongue.sensor_rest_positions + displacement,
        measured=np.tile([True, False, True], (len(order), 1)),
        frame="jaw",
        jaw_translation=jaw,
        source="demonstration",
    )


def _perform(score: list[tuple[NDArray[np.float64], float, float]]) -> NDArray[np.float64]:
    """Postures (5, 2) over time, (frame_count, 5, 2): reached along a minimum-jerk path, then held."""
    frames: list[NDArray[np.float64]] = []
    current = score[0][0]
    for posture, reach, hold in score:
        share = np.arange(1, round(reach * RATE) + 1) / max(1, round(reach * RATE))
        path = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
        frames.extend(current + s * (posture - current) for s in path)
        frames.extend([posture] * round(hold * RATE))
        current = posture
    return np.array(frames)
