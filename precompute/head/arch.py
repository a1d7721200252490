"""Dental arches: the curve through the crowns and the frame of each tooth on it (mm, head frame in bite)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .anatomy import Tooth
from .shapes import Array, PathFrame, curve_through


@dataclass(frozen=True, eq=False)
class ToothFrame:
    """Position and axes of a crown.

    neck: (3,) middle of the neck (gum line); axes: (3, 3) rows are mesial-to-distal along the arch towards
    the left, outward (lips, cheeks), and up the crown from neck to edge. along: arch length of its middle.
    """

    tooth: Tooth
    neck: Array
    axes: Array
    along: float

    def local(self, points: Array) -> Array:
        """Points (n, 3) in the crown's frame."""
        return (points - self.neck) @ self.axes.T

    def to_arch(self, points: Array) -> Array:
        """Points (n, 3) of the crown's frame in the arch's."""
        return self.neck + points @ self.axes

    def mirrored_distally(self) -> float:
        """+1 on the left side, -1 on the right: local first axis times this points distally."""
        return 1.0 if self.along > 0.0 else -1.0


@dataclass(frozen=True, eq=False)
class DentalArch:
    """One arch of 14 teeth.

    knots: (x, half-width) of the curve through the middles of the crowns; teeth: from the central incisor
    backwards; edge_height: z of the incisors' edge; up: +1 when the crowns point up (lower teeth), else -1.
    """

    knots: tuple[tuple[float, float], ...]
    teeth: tuple[Tooth, ...]
    edge_height: float
    up: float

    @cached_property
    def path(self) -> PathFrame:
        left = [(x, y) for x, y in self.knots[::-1]]
        right = [(x, -y) for x, y in self.knots[1:]]
        return PathFrame(curve_through(left + right, count=1500))

    @cached_property
    def middles(self) -> list[float]:
        """Arch length of the middle of each left tooth: neighbours touch."""
        middles, start = [], 0.0
        for tooth in self.teeth:
            middles.append(start + tooth.width / 2.0)
            start += tooth.width
        return middles

    @property
    def end(self) -> float:
        """Arch length of the last tooth's distal side."""
        return self.middles[-1] + self.teeth[-1].width / 2.0

    def edge_level(self, along: Array | float) -> Array:
        """Height of the occlusal surface over the arch: a gentle curve of Spee."""
        t = np.abs(along) / self.end
        return self.edge_height + 1.2 * np.sin(np.pi * t) * -1.0 + 1.5 * t**2

    def crown_height(self, along: Array) -> Array:
        """Distance from the occlusal surface to the gum line, smooth along the arch."""
        heights = [t.height - t.rise for t in (self.teeth[0], *self.teeth, self.teeth[-1])]
        return np.interp(np.abs(along), [0.0, *self.middles, self.end], heights)

    def neck_level(self, along: Array) -> Array:
        """z of the gum line at each tooth's middle, smooth along the arch."""
        return self.edge_level(along) - self.up * self.crown_height(along)

    def base_level(self, along: Array) -> Array:
        """z of the gum line without the differences between neighbouring teeth."""
        heights = [t.height for t in self.teeth]
        t = np.minimum(np.abs(along) / self.end, 1.0)
        front, back = float(np.mean(heights[:3])), float(np.mean(heights[5:]))
        return self.edge_level(along) - self.up * (front + (back - front) * t)

    @cached_property
    def frames(self) -> list[ToothFrame]:
        """The 14 teeth, left side then right, front to back."""
        pairs = list(zip(self.teeth, self.middles, strict=True))
        return [self._frame(tooth, side * middle) for side in (1.0, -1.0) for tooth, middle in pairs]

    def _frame(self, tooth: Tooth, along: float) -> ToothFrame:
        point, tangent = self.path.at(along)
        left = np.array([tangent[0], tangent[1], 0.0])
        outward = np.array([tangent[1], -tangent[0], 0.0])
        lean = np.radians(tooth.lean)
        axis = np.cos(lean) * np.array([0.0, 0.0, self.up]) + np.sin(lean) * outward
        facial = np.cos(lean) * outward - np.sin(lean) * np.array([0.0, 0.0, self.up])
        top = np.array([point[0], point[1], float(self.edge_level(along)) + self.up * tooth.rise])
        return ToothFrame(tooth, top - tooth.height * axis, np.stack([left, facial, axis]), along)
