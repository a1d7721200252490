"""How close the mouth is to any point, for the shade where the tongue touches it.

Distances to teeth, gums and palate are sampled once on a grid around the tongue, for the parts that move
with the jaw and for those that do not; a vertex of the tongue then reads both wherever it has moved to.
"""

from dataclasses import dataclass

import moderngl
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from .detail import DisplaySurface

REACH = 0.005
"""[m]: the mouth shades what is nearer than this."""

_STEP = 0.0022  # [m]
_AROUND = 0.010  # [m]: how far the tongue is expected to leave its bounding box at rest


@dataclass(frozen=True, eq=False)
class Closeness:
    """values: (nz, ny, nx, 2) bytes, 255 in contact and 0 beyond REACH: to the head's parts and the jaw's.
    low, high: (3,) [m], the grid's box, whose faces are the outer faces of the first and last texels.
    """

    values: NDArray[np.uint8]
    low: NDArray[np.float64]
    high: NDArray[np.float64]

    def texture(self, context: moderngl.Context) -> moderngl.Texture3D:
        """The grid on the graphics device."""
        nz, ny, nx, channels = self.values.shape
        texture = context.texture3d((nx, ny, nz), channels, self.values.tobytes(), alignment=1)
        texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
        texture.repeat_x = texture.repeat_y = texture.repeat_z = False
        return texture


def closeness(rest: NDArray[np.floating], mouth: tuple[DisplaySurface, ...]) -> Closeness:
    """The grid around the tongue's rest vertices (n, 3) [m]; bone, deep below mucosa, does not count."""
    low, high = rest.min(axis=0) - _AROUND, rest.max(axis=0) + _AROUND
    shape = np.maximum(np.ceil((high - low) / _STEP).astype(int), 1)
    axes = [low[a] + (np.arange(shape[a]) + 0.5) * (high[a] - low[a]) / shape[a] for a in range(3)]
    points = np.stack(np.meshgrid(*axes[::-1], indexing="ij"), axis=-1)[..., ::-1].reshape(-1, 3)
    values = np.zeros((len(points), 2))
    for channel, frame in enumerate(("head", "jaw")):
        parts = [s.vertices for s in mouth if s.frame == frame and s.tissue != "bone"]
        if parts:
            distance = cKDTree(np.concatenate(parts)).query(points, distance_upper_bound=REACH)[0]
            values[:, channel] = 1.0 - np.minimum(distance / REACH, 1.0)
    return Closeness(np.round(255.0 * values).astype(np.uint8).reshape(*shape[::-1], 2), low, high)
