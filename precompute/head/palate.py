"""Palate with upper gums, velum and uvula, and the upper teeth, as signed distances (mm, head frame)."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .anatomy import HeadAnatomy
from .arch import DentalArch, ToothFrame
from .jaw import gum_ridge
from .shapes import (
    Array,
    PlanarField,
    curve_through,
    ellipsoid,
    monotone,
    rounded_chain,
    rounded_extrusion,
    smooth_difference,
    smooth_intersection,
    smooth_union,
    superellipse,
)
from .teeth import crown


@dataclass(frozen=True, eq=False)
class UpperJaw:
    """The parts of the upper mouth built from `anatomy`."""

    anatomy: HeadAnatomy

    @cached_property
    def arch(self) -> DentalArch:
        return DentalArch(self.anatomy.upper_arch, self.anatomy.upper_teeth, 0.0, up=-1.0)

    def tooth(self, points: Array, frame: ToothFrame) -> Array:
        """One upper crown, (n,)."""
        return crown(points, frame)

    def teeth(self, points: Array) -> Array:
        """All upper crowns, (n,)."""
        return np.min([crown(points, frame) for frame in self.arch.frames], axis=0)

    def palate(self, points: Array) -> Array:
        """Hard palate with its gums, velum and uvula, (n,)."""
        gums = gum_ridge(points, self.arch, depth=11.0, lean=0.38)
        hard = smooth_union(gums, self._vault(points), 8.0)
        bone = ellipsoid(points, (-15.0, 0.0, 17.0), (15.5, 19.0, 5.0))  # above the incisors' roots
        bone = smooth_difference(bone, self._cavity(*points.T) - 2.0, 2.0)
        hard = smooth_union(hard, bone, 10.0)
        return smooth_union(hard, self._velum(points), 7.0)

    def _vault(self, points: Array) -> Array:
        """A shell of constant thickness over the oral cavity."""
        x, y, z = points.T
        thickness = self.anatomy.palate_thickness
        cavity = self._cavity(x, y, z)
        shell = np.maximum(-cavity, cavity - thickness)
        _, across = self.arch.path.coordinates(points[:, :2])
        low = 8.0 - z  # only above the gum line
        shell = smooth_intersection(shell, low, 2.0)
        shell = smooth_intersection(shell, across + 3.0, 4.0)
        return smooth_intersection(shell, -50.0 - x, 3.0)

    def _cavity(self, x: Array, y: Array, z: Array) -> Array:
        """Distance above the roof of the mouth: half superellipses across, over the midline's height."""
        height = self.anatomy.palate_height
        rise = monotone(
            [-60.0, -48.0, -36.0, -26.0, -20.0, -15.0, -10.0, -4.0],
            [
                height - 1.2,
                height,
                height + 0.4,
                height - 2.0,
                height - 5.6,
                height - 9.2,
                height - 12.0,
                6.0,
            ],
        )
        width = monotone([-60.0, -45.0, -31.0, -20.0, -13.0, -8.0, -4.0], [23.5, 21.8, 19.4, 16.2, 12.9, 9.8, 7.0])
        floor = 1.0
        top, half = rise(x) - floor, width(x)
        u, v = np.abs(y) / half, np.maximum(z - floor, 0.0) / top
        power = 2.5
        norm = np.maximum(u**power + v**power, 1e-9) ** (1.0 / power)
        slope = norm ** (1.0 - power) * np.hypot(u ** (power - 1.0) / half, v ** (power - 1.0) / top)
        lift = (rise(x + 0.5) - rise(x - 0.5)) * v / np.maximum(top, 1.0)  # the roof's own steepness
        return (norm - 1.0) / np.maximum(np.hypot(slope, lift), 0.02)

    @cached_property
    def _velum_outline(self) -> PlanarField:
        z = self.anatomy.palate_height
        return PlanarField(
            curve_through(
                [
                    (-42.0, z + 1.0),
                    (-50.0, z - 0.3),
                    (-57.0, z - 3.5),
                    (-63.5, z - 9.0),
                    (-68.3, z - 15.5),
                    (-70.8, z - 21.0),
                    (-73.0, z - 23.0),
                    (-75.2, z - 20.6),
                    (-75.2, z - 14.0),
                    (-72.0, z - 5.5),
                    (-65.5, z + 1.8),
                    (-56.0, z + 4.5),
                    (-47.0, z + 4.6),
                    (-42.0, z + 3.8),
                ],
                closed=True,
            )
        )

    def _velum(self, points: Array) -> Array:
        x, y, z = points.T
        back = np.clip((-x - 48.0) / 24.0, 0.0, 1.2)
        droop = (0.006 + 0.010 * back) * y**2
        profile = self._velum_outline(x, z + droop)
        sheet = rounded_extrusion(profile, np.abs(y) - 22.0, 1.6)
        # The free edge is round: an ellipse in the plane of the velum, which hangs down at 45 degrees.
        down = np.maximum((self.anatomy.palate_height - z - x - 50.0) * np.sqrt(0.5), 0.0)
        edge = superellipse(y, down, 22.0, self.anatomy.velum_length - 1.0, 2.3)
        sheet = smooth_intersection(sheet, edge, 3.0)
        z0 = self.anatomy.palate_height
        path = np.array([[-72.6, 0.0, z0 - 19.0], [-73.6, 0.0, z0 - 25.0], [-73.2, 0.0, z0 - 29.5]])
        return smooth_union(sheet, rounded_chain(points, path, np.array([3.0, 3.0, 2.4])), 3.5)
