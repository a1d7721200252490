"""Orbit camera around the mouth, head frame: x anterior, y left, z up [m]."""

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

_UP = np.array([0.0, 0.0, 1.0])
_ELEVATION_LIMIT = np.deg2rad(89.0)
_MARGIN = 1.1  # room around what is framed


@dataclass
class Camera:
    """Looks at `target` from `distance` away.

    target: (3,) [m]. distance [m]. azimuth, elevation [rad]: direction from the target to the eye;
    azimuth 0 is in front of the face, pi/2 on its left, so that the lateral view has the tip on the
    left of the picture. field_of_view [rad]: vertical. extent [m]: radius of what there is to see,
    for the depth range. orthographic: parallel projection of the same height at the target.
    subject: (n, 3) points [m] that the built-in views frame, None to keep target and distance;
    subject_aspect: width over height of the narrowest picture that must hold them.
    """

    target: NDArray[np.float64] = field(default_factory=lambda: np.zeros(3))
    distance: float = 0.25
    azimuth: float = np.deg2rad(52.0)
    elevation: float = np.deg2rad(20.0)
    field_of_view: float = np.deg2rad(26.0)
    extent: float = 0.1
    orthographic: bool = False
    subject: NDArray[np.float64] | None = None
    subject_aspect: float = 1.0

    def direction(self) -> NDArray[np.float64]:
        """Unit vector from the target to the eye, (3,)."""
        ce, se = np.cos(self.elevation), np.sin(self.elevation)
        return np.array([ce * np.cos(self.azimuth), ce * np.sin(self.azimuth), se])

    @property
    def eye(self) -> NDArray[np.float64]:
        """Position of the eye [m], (3,)."""
        return self.target + self.distance * self.direction()

    def axes(self) -> NDArray[np.float64]:
        """Rows: right, up and backward (towards the viewer) of the picture in the head frame, (3, 3)."""
        back = self.direction()
        right = np.cross(_UP, back)
        right /= np.linalg.norm(right)
        return np.stack([right, np.cross(back, right), back])

    def view_matrix(self) -> NDArray[np.float64]:
        """Head frame to eye frame, (4, 4)."""
        matrix = np.eye(4)
        matrix[:3, :3] = self.axes()
        matrix[:3, 3] = -matrix[:3, :3] @ self.eye
        return matrix

    def projection_matrix(self, aspect: float) -> NDArray[np.float64]:
        """Eye frame to clip space, (4, 4); `aspect` is width over height."""
        near = max(self.distance - 2.5 * self.extent, 0.02 * self.distance)
        far = self.distance + 2.5 * self.extent
        height = np.tan(0.5 * self.field_of_view)
        matrix = np.zeros((4, 4))
        if self.orthographic:
            height *= self.distance
            matrix[2, 2], matrix[2, 3] = -2.0 / (far - near), -(far + near) / (far - near)
            matrix[3, 3] = 1.0
        else:
            matrix[2, 2], matrix[2, 3] = -(far + near) / (far - near), -2.0 * far * near / (far - near)
            matrix[3, 2] = -1.0
        matrix[0, 0], matrix[1, 1] = 1.0 / (height * aspect), 1.0 / height
        return matrix

    def view_projection(self, aspect: float) -> NDArray[np.float64]:
        """Head frame to clip space, (4, 4)."""
        return self.projection_matrix(aspect) @ self.view_matrix()

    def project(self, points: NDArray[np.floating], width: float, height: float) -> NDArray[np.float64]:
        """Pixel coordinates of head-frame points (n, 3) [m]: (n, 3) of x right, y down, depth in [-1, 1].

        Points behind the eye have NaN.
        """
        homogeneous = np.column_stack([points, np.ones(len(points))])
        clip = homogeneous @ self.view_projection(width / height).T
        w = np.where(clip[:, 3:] > 0.0, clip[:, 3:], np.nan)
        ndc = clip[:, :3] / w
        return np.column_stack([0.5 * width * (1 + ndc[:, 0]), 0.5 * height * (1 - ndc[:, 1]), ndc[:, 2]])

    def orbit(self, right: float, up: float) -> None:
        """Turns around the target by angles [rad] as if the mouth were dragged right and up."""
        self.azimuth = (self.azimuth - right + np.pi) % (2.0 * np.pi) - np.pi
        self.elevation = float(np.clip(self.elevation - up, -_ELEVATION_LIMIT, _ELEVATION_LIMIT))

    def pan(self, right: float, up: float) -> None:
        """Shifts what is seen by fractions of the picture's height."""
        axes = self.axes()
        height = 2.0 * self.distance * np.tan(0.5 * self.field_of_view)
        self.target = self.target - height * (right * axes[0] + up * axes[1])

    def zoom(self, steps: float) -> None:
        """Comes nearer by `steps` notches of a mouse wheel (about 10 % each)."""
        distance = self.distance * 0.9**steps
        self.distance = float(np.clip(distance, 0.25 * self.extent, 20.0 * self.extent))

    def look(self, view: str) -> None:
        """Takes the direction of a built-in view (VIEWS) and frames the subject, if there is one, anew."""
        azimuth, elevation = VIEWS[view]
        self.azimuth, self.elevation = float(np.deg2rad(azimuth)), float(np.deg2rad(elevation))
        if self.subject is not None:
            self._frame(self.subject)

    def _frame(self, points: NDArray[np.float64]) -> None:
        """Puts the points (n, 3) into the middle of the picture, as large as they fit.

        In eye coordinates (right, up, backward) a point at (a, b, c) is inside when |a - a0| is at most
        the half-width of the picture at its depth, s (d + c0 - c) with s the slope of the frustum's side:
        a0 and the distance d follow from the extremes of a + s c and a - s c, and likewise for up.
        """
        axes = self.axes()
        at = points @ axes.T
        backward = 0.5 * (at[:, 2].min() + at[:, 2].max())
        deep = at[:, 2] - backward
        middle, distance = np.zeros(3), 0.0
        tangent = np.tan(0.5 * self.field_of_view)
        for axis, slope in enumerate((tangent * self.subject_aspect, tangent)):
            side = slope / _MARGIN
            high, low = (at[:, axis] + side * deep).max(), (at[:, axis] - side * deep).min()
            middle[axis] = 0.5 * (high + low)
            flat = np.abs(at[:, axis] - middle[axis]).max()  # half the extent in a parallel projection
            distance = max(distance, 0.5 * (high - low) / side, flat / side)
        middle[2] = backward
        self.target, self.distance = middle @ axes, float(distance)

    def copy(self) -> "Camera":
        """An independent camera in the same place."""
        return replace(self, target=self.target.copy())


VIEWS = {"three-quarter": (50.0, 22.0), "lateral": (90.0, 0.0), "front": (0.0, 8.0), "top": (90.0, 89.0)}
"""Built-in views: name to (azimuth, elevation) [degrees]."""


def framing(points: NDArray[np.floating], view: str = "three-quarter", aspect: float = 1.0) -> Camera:
    """A camera that has `points` (n, 3) [m] in its picture from a built-in view, as large as they fit.

    aspect: width over height of the narrowest picture that must hold them.
    """
    everything = np.asarray(points, dtype=np.float64)
    extent = 0.5 * float(np.linalg.norm(np.ptp(everything, axis=0)))
    camera = Camera(extent=extent, subject=everything, subject_aspect=aspect)
    camera.look(view)
    return camera
