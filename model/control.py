"""What drives a solver during one step."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from .pose import RigidPose


@dataclass
class Control:
    """Inputs of one step; the caller may reuse and overwrite the same object.

    sensor_targets: (sensor_count, 3) float64 [m], jaw frame: where the coils are at the end of the step.
    sensor_constrained: (sensor_count, 3) bool: which of those coordinates are imposed.
    gravity: (3,) float64 [m/s^2], jaw frame. Zero by default: the rest shape is the one at rest in gravity.
    jaw_pose: pose of the jaw in the head.
    """

    sensor_targets: NDArray[np.float64]
    sensor_constrained: NDArray[np.bool_]
    gravity: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    jaw_pose: RigidPose = field(default_factory=RigidPose)
