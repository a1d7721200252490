"""The tongue at rest as a signed distance (mm, head frame), and where bone holds it.

A midsagittal outline is given thickness from side to side: the half-width depends on the place in the
midsagittal plane, the edges are rounded, the dorsum falls away from the midline and carries the median
sulcus.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .anatomy import HeadAnatomy
from .jaw import Jaw
from .shapes import (
    Array,
    PlanarField,
    bump,
    curve_through,
    monotone,
    rounded_extrusion,
    smooth_difference,
    smoothstep,
)


@dataclass(frozen=True, eq=False)
class Tongue:
    """The tongue built from `anatomy`, in the floor of `jaw`."""

    anatomy: HeadAnatomy
    jaw: Jaw

    @cached_property
    def outline(self) -> Array:
        """Midsagittal outline (k, 2) [x, z]."""
        return curve_through(list(self.anatomy.tongue_outline), closed=True, count=500)

    @cached_property
    def _profile(self) -> PlanarField:
        return PlanarField(self.outline)

    def body(self, points: Array) -> Array:
        """The tongue, (n,)."""
        x, y, z = points.T
        dorsal = smoothstep(-24.0, -4.0, z)
        drop = (0.0105 * dorsal + 0.002) * y**2 * smoothstep(-4.0, -20.0, x)
        forward = 0.011 * y**2 * smoothstep(-42.0, -58.0, x)  # the root is round from side to side
        profile = self._profile(x - forward, z + drop)
        beside = np.abs(y) - self._half_width(x, z)
        radius = monotone([-70.0, -45.0, -25.0, -12.0, -8.0], [9.5, 8.5, 5.5, 3.2, 2.6])(x)
        body = rounded_extrusion(profile, beside, radius)
        body = body + self._sulcus(x, y, z)
        body = smooth_difference(body, self.jaw.lingual_wall(points) - 0.2, 4.0)
        return smooth_difference(body, np.minimum(self.jaw.bone(points), self.jaw.hyoid(points)) - 0.2, 1.5)

    def _half_width(self, x: Array, z: Array) -> Array:
        """Half the tongue's width where bulk is not limited by anything else [mm]."""
        blade = monotone(
            [-75.0, -60.0, -50.0, -40.0, -30.0, -22.0, -15.0, -11.0, -8.5, -7.0],
            [27.0, 27.4, 25.4, 22.3, 19.4, 16.8, 13.6, 10.8, 7.4, 4.0],
        )(x)
        floor = monotone([-70.0, -55.0, -40.0, -25.0], [23.0, 21.5, 17.8, 13.5])(x)
        above = smoothstep(-20.0, -2.0, z)
        return floor + (blade - floor) * above

    def _sulcus(self, x: Array, y: Array, z: Array) -> Array:
        """Depth of the median groove, on the upper surface between tip and root."""
        depth = monotone([-66.0, -58.0, -45.0, -25.0, -14.0, -9.0], [0.0, 0.9, 1.7, 1.5, 0.8, 0.0])(x)
        return depth * bump(y, 3.2) * smoothstep(-12.0, -4.0, z)

    def attached(self, points: Array) -> Array:
        """Which points (n, 3) of the tongue bone holds, (n,) bool: three attachments.

        Genioglossus and geniohyoid on the genial tubercle; hyoglossus and root on the hyoid; the floor on
        the mylohyoid sling, which is taken as rigid with the jaw: the lowest 3 mm of the body.
        """
        genial = np.linalg.norm(points - self.jaw.genial_tubercle, axis=1) < 9.0
        hyoid = (self.jaw.hyoid(points) < 5.5) & (points[:, 2] < -36.0)
        floor = self._floor_depth(points) < 3.0
        return genial | hyoid | floor

    def _floor_depth(self, points: Array) -> Array:
        """Height above the tongue's underside along the vertical [mm], (n,)."""
        lowest = self.outline[(self.outline[:, 1] < -36.0) & (self.outline[:, 0] > -60.0)]
        order = np.argsort(lowest[:, 0])
        drop = 0.002 * points[:, 1] ** 2
        return points[:, 2] + drop - np.interp(points[:, 0], lowest[order, 0], lowest[order, 1])
