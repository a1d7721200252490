"""Signed distance to the rigid parts of the mouth on dense grids, one for each frame, and their Warp form."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.precision import precision
from ..kernels.signed_distance import FAR, distance_functions

FRAMES = ("jaw", "head")
"""The frames that rigid parts move with, in the order in which contact arrays list them."""


@dataclass(frozen=True, eq=False)
class SignedDistanceGrid:
    """Distance to the union of the rigid parts of one frame, negative inside, around the tongue's reach.

    frame: "jaw" or "head", in which the coordinates are. lower: (3,) [m]: where values[0, 0, 0] sits.
    spacing: [m]. values: (nx, ny, nz) float32 [m]: coefficients of a triquadratic B-spline.
    Beyond the outermost coefficients nothing is touched.
    """

    frame: str
    lower: NDArray[np.float64]
    spacing: float
    values: NDArray[np.float32]

    def on_device(self, precision_name: str, device: str) -> Any:
        """The grid as an argument of kernels."""
        grid = distance_functions(precision_name).Grid()
        grid.values = wp.array(self.values, dtype=wp.float32, device=device)
        grid.lower = precision(precision_name).vec3(*self.lower)
        grid.spacing = precision(precision_name).scalar(self.spacing)
        return grid

    def sample(
        self, points: NDArray[np.floating], precision_name: str = "float64", device: str = "cpu"
    ) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
        """Signed distance (n,) [m] and its gradient (n, 3) at points (n, 3) [m] in the grid's frame."""
        functions = distance_functions(precision_name)
        out = wp.empty(len(points), dtype=functions.vec4, device=device)
        at: wp.array = wp.array(points, dtype=precision(precision_name).vec3, device=device)
        wp.launch(functions.sample, len(points), [self.on_device(precision_name, device), at], [out], device=device)
        result = out.numpy()
        return result[:, 0], result[:, 1:]


def empty_grid(frame: str) -> SignedDistanceGrid:
    """The grid of a frame without rigid parts: everything is far from it."""
    return SignedDistanceGrid(frame, np.zeros(3), 1.0, np.full((1, 1, 1), FAR, dtype=np.float32))


def by_frame(grids: tuple[SignedDistanceGrid, ...]) -> tuple[SignedDistanceGrid, SignedDistanceGrid]:
    """The grids in the order of FRAMES, an empty one where a frame has none."""
    found = {grid.frame: grid for grid in grids}
    jaw, head = (found.get(frame) or empty_grid(frame) for frame in FRAMES)
    return jaw, head
