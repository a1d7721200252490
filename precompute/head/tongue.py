"""The tongue at rest as a signed distance (mm, head frame), and where bone holds it.

A midsagittal outline is given thickness from side to side: the half-width depends on the place in the
midsagittal plane, the edges are rounded, the dorsum falls away from the midline and carries the median
sulcus. Below the lateral margins the body tapers to the muscles of the floor, which are a fan in the
midsagittal plane: narrow at the genial tubercle, wide at the hyoid, and round underneath, where the
mylohyoid carries them like a sling.
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

WALL_CLEARANCE = 0.3
"""Room between the tongue's sides and the lower teeth and gums [mm]."""

BONE_CLEARANCE = 1.0
"""Room between the tongue and bone, where periosteum and mucosa lie [mm]."""

SLING = 0.022
"""Rise of the underside beside the midline, mm per mm^2."""


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
        forward = 0.011 * y**2 * smoothstep(-42.0, -58.0, x)  # the root is round from side to side
        profile = self._profile(x - forward, z + self._droop(x, y, z))
        beside = np.abs(y) - self._half_width(x, z)
        radius = monotone([-70.0, -45.0, -25.0, -12.0, -8.0], [9.5, 8.5, 5.5, 3.2, 2.3])(x)
        body = rounded_extrusion(profile, beside, radius)
        body = body + self._sulcus(x, y, z)
        body = smooth_difference(body, self.jaw.lingual_wall(points) - WALL_CLEARANCE, 5.5)
        bone = np.minimum(self.jaw.bone(points), self.jaw.hyoid(points))
        return smooth_difference(body, bone - BONE_CLEARANCE, 2.5)

    def _droop(self, x: Array, y: Array, z: Array) -> Array:
        """How much lower than the midline the outline lies beside it: the dorsum falls, the floor rises [mm]."""
        dorsal, ventral = smoothstep(-24.0, -4.0, z), smoothstep(-16.0, -34.0, z)
        return (0.0125 * dorsal * smoothstep(-4.0, -20.0, x) - SLING * ventral) * y**2

    def _half_width(self, x: Array, z: Array) -> Array:
        """Half the tongue's width where bulk is not limited by anything else [mm]."""
        blade = monotone(
            [-75.0, -60.0, -50.0, -40.0, -30.0, -22.0, -15.0, -11.0, -8.5, -7.0],
            [25.0, 25.8, 24.8, 22.3, 19.4, 16.8, 13.6, 10.8, 7.4, 4.0],
        )(x)
        floor = monotone([-68.0, -58.0, -48.0, -38.0, -30.0, -24.0, -19.0], [19.0, 18.5, 16.5, 13.5, 10.0, 7.0, 5.5])(x)
        above = smoothstep(-38.0, -8.0, z)
        return floor + (blade - floor) * above

    def _sulcus(self, x: Array, y: Array, z: Array) -> Array:
        """Depth of the median groove, on the upper surface between tip and root."""
        depth = monotone([-66.0, -58.0, -45.0, -25.0, -14.0, -9.0], [0.0, 1.0, 2.0, 1.8, 1.0, 0.0])(x)
        return depth * bump(y, 3.0) * smoothstep(-12.0, -4.0, z)

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
        rise = SLING * points[:, 1] ** 2
        return points[:, 2] - rise - np.interp(points[:, 0], lowest[order, 0], lowest[order, 1])
