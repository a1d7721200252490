"""The uniform block that every shader of one picture shares (shaders/frame.glsl)."""

import moderngl
import numpy as np
from numpy.typing import NDArray

from .camera import Camera

_KEY = np.array([-0.52, 0.68, 0.52])
_FILL = np.array([0.85, 0.05, 0.45])
_RIM = np.array([0.45, 0.55, -0.75])
"""Directions towards the lights in the picture's axes (right, up, towards the viewer)."""

BACKDROP_COLOURS = {
    "dark": ((0.262, 0.288, 0.322, 1.0), (0.082, 0.092, 0.110, 1.0)),
    "light": ((0.985, 0.985, 0.985, 1.0), (0.835, 0.850, 0.868, 1.0)),
    "transparent": ((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)),
}
"""Centre and edge of the backdrop, display values and alpha."""

_SIZE = 4 * (16 + 9 * 4)


class FrameUniforms:
    """Owns the block's buffer, bound to binding 0."""

    def __init__(self, context: moderngl.Context) -> None:
        self._buffer = context.buffer(reserve=_SIZE, dynamic=True)
        self._values = np.zeros(_SIZE // 4, dtype=np.float32)

    def write(self, camera: Camera, aspect: float, backdrop: str, clip_plane: NDArray[np.floating]) -> None:
        """Fills the block for one picture.

        aspect: width over height. backdrop: a key of BACKDROP_COLOURS. clip_plane: (4,), head frame;
        points with plane . (p, 1) < 0 are cut away.
        """
        axes = camera.axes()
        key, fill, rim = ((d / np.linalg.norm(d)) @ axes for d in (_KEY, _FILL, _RIM))
        side = np.cross(axes[1], key)
        side /= np.linalg.norm(side)
        rows = np.zeros((9, 4))
        rows[:6, :3] = camera.eye, key, side, np.cross(key, side), fill, rim
        rows[6] = clip_plane
        rows[7:9] = BACKDROP_COLOURS[backdrop]
        self._values[:16] = camera.view_projection(aspect).T.ravel()
        self._values[16:] = rows.ravel()
        self._buffer.write(self._values)
        self._buffer.bind_to_uniform_block(0)

    def release(self) -> None:
        self._buffer.release()


def midsagittal_plane(camera: Camera, midline: float = 0.0) -> NDArray[np.float64]:
    """The plane y = midline [m] that cuts away the half on the eye's side, (4,)."""
    sign = -1.0 if camera.eye[1] >= midline else 1.0
    return np.array([0.0, sign, 0.0, -sign * midline])


NO_CLIPPING = np.array([0.0, 0.0, 0.0, 1.0])
