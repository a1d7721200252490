"""Rigid motion between the jaw frame and the head frame."""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, eq=False)
class RigidPose:
    """Takes jaw coordinates to head coordinates: x_head = rotation @ x_jaw + translation.

    rotation: (3, 3) float64; translation [m]: (3,) float64. The identity is the rest pose.
    """

    rotation: NDArray[np.float64] = field(default_factory=lambda: np.eye(3))
    translation: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))

    def apply(self, points: NDArray[np.floating]) -> NDArray[np.floating]:
        """Transforms points (..., 3) [m] from the jaw frame to the head frame."""
        return points @ self.rotation.T + self.translation

    def matrix(self) -> NDArray[np.float64]:
        """The same motion as a homogeneous matrix, (4, 4)."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.rotation
        matrix[:3, 3] = self.translation
        return matrix
