"""Mandible, lower gums, lower teeth and hyoid as signed distances (mm, head frame at rest).

Everything that moves with the mandible is described in bite and turned about the condyles by the rest
opening; the hyoid is placed at rest.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .anatomy import HeadAnatomy
from .arch import DentalArch, ToothFrame
from .shapes import (
    Array,
    PlanarField,
    bump,
    curve_through,
    ellipsoid,
    rounded_chain,
    rounded_extrusion,
    smooth_difference,
    smooth_intersection,
    smooth_union,
    smoothstep,
    sphere,
)
from .teeth import crown

MUCOSA_THICKNESS = 0.7
"""Of the lower gums over bone [mm]."""


@dataclass(frozen=True, eq=False)
class Jaw:
    """The parts of the lower jaw built from `anatomy`."""

    anatomy: HeadAnatomy

    @cached_property
    def arch(self) -> DentalArch:
        return DentalArch(self.anatomy.lower_arch, self.anatomy.lower_teeth, self.anatomy.overbite, up=1.0)

    @cached_property
    def opening_angle(self) -> float:
        """Rotation about the condyles from bite to rest [rad]."""
        x, _, z = self.anatomy.condyle
        return self.anatomy.rest_opening / float(np.hypot(x - self.arch.knots[0][0], z))

    def to_bite(self, points: Array) -> Array:
        """Points at rest (n, 3) taken to where they are in bite."""
        return self._turned(points, self.opening_angle)

    def to_rest(self, points: Array) -> Array:
        """Points in bite (n, 3) taken to where they are at rest."""
        return self._turned(points, -self.opening_angle)

    def _turned(self, points: Array, angle: float) -> Array:
        x0, _, z0 = self.anatomy.condyle
        c, s = np.cos(angle), np.sin(angle)
        x, z = points[:, 0] - x0, points[:, 2] - z0
        return np.stack([x0 + c * x - s * z, points[:, 1], z0 + s * x + c * z], axis=1)

    def tooth(self, points: Array, frame: ToothFrame) -> Array:
        """One lower crown, (n,)."""
        return crown(self.to_bite(points), frame)

    def teeth(self, points: Array) -> Array:
        """All lower crowns, (n,)."""
        bite = self.to_bite(points)
        return np.min([crown(bite, frame) for frame in self.arch.frames], axis=0)

    def lingual_wall(self, points: Array) -> Array:
        """A smooth band that contains lower crowns and gums, (n,): what the tongue's sides lean on."""
        p = self.to_bite(points)
        along, across = self.arch.path.coordinates(p[:, :2])
        s, teeth = np.abs(along), self.arch.teeth
        knots = [0.0, *self.arch.middles, self.arch.end]
        neck = np.interp(s, knots, [t.depth / 2.0 for t in (teeth[0], *teeth, teeth[-1])])
        edge = np.interp(s, self.arch.middles[1:5], [0.35, 0.5, 0.8, 0.95])  # incisors are thin at the edge
        facing = np.tan(np.radians(np.interp(s, knots, [t.lean for t in (teeth[0], *teeth, teeth[-1])])))
        below = np.maximum(self.arch.edge_level(s) - p[:, 2], 0.0)
        half = neck * (edge + (1.0 - edge) * smoothstep(0.0, 6.0, below))
        wall = np.abs(across + facing * np.minimum(below, 10.0)) - half - 1.9 * smoothstep(0.5, 6.5, below)
        wall = wall - 0.7 * smoothstep(self.arch.middles[5], self.arch.end, s)  # the pad behind the teeth
        top = p[:, 2] - self.arch.edge_level(s) - 0.5
        base = self.arch.base_level(s) - 9.0 - p[:, 2]
        wall = smooth_intersection(smooth_intersection(wall, top, 3.0), base, 3.0)
        return smooth_intersection(wall, s - self.arch.end - 5.5, 6.0)

    def gums(self, points: Array) -> Array:
        """Mucosa over the alveolar ridge, scalloped around the necks, and over the bone in it, (n,)."""
        return gum_ridge(self.to_bite(points), self.arch, 9.0, 0.06, self.bone(points) - MUCOSA_THICKNESS)

    @cached_property
    def _body_pieces(self) -> tuple[Array, Array]:
        """Lines from the alveolar crest to the lower border, left half: tops and bottoms (k, 3)."""
        a = self.anatomy
        tops, bottoms = [], []
        border = curve_through(
            [
                a.menton,
                (a.menton[0] + 0.5, 9.0, a.menton[2] + 0.5),
                (-16.5, 18.5, -35.6),
                (-34.0, 29.5, -32.0),
                (-54.0, 38.8, -27.8),
                (a.gonion[0] + 7.0, a.gonion[1] - 1.5, a.gonion[2] + 2.0),
            ],
            count=90,
        )
        crest = curve_through(
            [
                (-6.2, 0.0),
                (-7.6, 7.0),
                (-11.6, 13.6),
                (-20.5, 19.6),
                (-31.0, 24.2),
                (-43.0, 29.6),
                (-51.0, 34.6),
                (-58.0, 41.0),
            ],
            count=90,
        )
        for (x, y), bottom in zip(crest, border, strict=True):
            along = self.arch.path.coordinates(np.array([[x, y]]))[0][0]
            neck = float(self.arch.base_level(np.array(min(along, self.arch.end))))
            tops.append([x, y, neck - 6.5])
            bottoms.append(bottom)
        return np.array(tops), np.array(bottoms)

    @cached_property
    def _ramus_outline(self) -> PlanarField:
        a = self.anatomy
        cx, _, cz = a.condyle
        gx, _, gz = a.gonion
        return PlanarField(
            curve_through(
                [
                    (gx + 14.0, gz - 3.0),
                    (gx + 4.0, gz + 0.5),
                    (gx - 1.5, gz + 9.0),
                    (gx - 3.5, gz + 24.0),
                    (cx - 5.0, cz - 14.0),
                    (cx - 5.5, cz - 4.0),
                    (cx - 1.0, cz + 1.0),
                    (cx + 4.5, cz - 3.0),
                    (cx + 10.0, cz - 13.5),
                    (cx + 17.0, cz - 15.5),
                    (cx + 23.0, cz - 8.0),
                    (cx + 27.0, cz - 2.0),
                    (cx + 30.5, cz - 5.0),
                    (cx + 31.0, cz - 15.0),
                    (cx + 31.5, cz - 27.0),
                    (cx + 36.0, cz - 38.0),
                    (cx + 36.0, cz - 50.0),
                    (gx + 26.0, gz - 3.5),
                ],
                closed=True,
            )
        )

    def bone(self, points: Array) -> Array:
        """The mandible without its teeth, (n,)."""
        a = self.anatomy
        p = self.to_bite(points)
        p = np.stack([p[:, 0], np.abs(p[:, 1]), p[:, 2]], axis=1)
        body = self._body(p)
        side = a.gonion[1] - 0.5 + (p[:, 2] - a.gonion[2]) * 0.055 - 4.5 * smoothstep(-60.0, -45.0, p[:, 0])
        plate = rounded_extrusion(
            self._ramus_outline(p[:, 0], p[:, 2]), np.abs(p[:, 1] - side) - a.ramus_thickness / 2.0, 3.2
        )
        x, y, z = a.condyle
        head = ellipsoid(p, (x, y - 1.0, z - 1.5), (4.5, 9.5, 5.0))
        bone = smooth_union(smooth_union(body, plate, 9.0), head, 5.0)
        return self._chin(bone, p)

    def _body(self, p: Array) -> Array:
        """Union of rounded bars along the pieces; far away, of every ninth of them only."""
        body = self._bars(p, 9)
        near = body < 12.0
        body[near] = self._bars(p[near], 1)
        return body

    def _bars(self, p: Array, stride: int) -> Array:
        tops, bottoms = self._body_pieces
        best = np.full(len(p), np.inf)
        half = self.anatomy.body_thickness / 2.0
        for top, bottom in zip(tops[::stride], bottoms[::stride], strict=True):
            edge = bottom - top
            length = float(np.linalg.norm(edge))
            offset = p - top
            t = np.clip(offset @ edge / length**2, 0.0, 1.0 - (half + 0.3) / length)
            distance = np.linalg.norm(offset - t[:, None] * edge, axis=1)
            best = np.minimum(best, distance - half * (0.82 + 0.22 * np.sin(np.pi * 0.8 * t)))
        return best

    def _chin(self, bone: Array, p: Array) -> Array:
        """Mental protuberance and tubercles outside, genial tubercle inside, mental foramina."""
        x, _, z = self.anatomy.menton
        bone = smooth_union(bone, ellipsoid(p, (x + 2.0, 0.0, z + 7.0), (6.0, 8.0, 5.0)), 6.0)
        bone = smooth_union(bone, sphere(p, (x - 0.5, 10.0, z + 4.0), 5.0), 7.0)
        bone = smooth_union(bone, sphere(p, self.genial_tubercle_bite, 1.6), 3.0)
        return smooth_difference(bone, sphere(p, (-22.5, 29.8, -22.0), 1.7), 1.5)

    @property
    def genial_tubercle_bite(self) -> tuple[float, float, float]:
        x, _, z = self.anatomy.menton
        return (x - 6.5, 0.0, z + 9.0)

    @property
    def genial_tubercle(self) -> Array:
        """Point at rest, (3,)."""
        return self.to_rest(np.array([self.genial_tubercle_bite]))[0]

    def hyoid(self, points: Array) -> Array:
        """Hyoid bone: body, greater horns backwards and upwards, lesser horns, (n,)."""
        a = self.anatomy
        cx, _, cz = a.hyoid_centre
        p = np.stack([points[:, 0], np.abs(points[:, 1]), points[:, 2]], axis=1)
        w, long = a.hyoid_half_width, a.hyoid_horn_length
        path = curve_through(
            [
                (cx, 0.0, cz),
                (cx - 1.2, 0.5 * w, cz),
                (cx - 5.0, w, cz + 0.5),
                (cx - 5.0 - 0.5 * long, w + 6.5, cz + 3.0),
                (cx - 5.0 - 0.93 * long, w + 10.0, cz + 6.5),
            ],
            count=24,
        )
        thickness = np.interp(np.linspace(0.0, 1.0, 24), [0.0, 0.25, 0.5, 0.97, 1.0], [3.2, 3.0, 2.2, 1.7, 2.3])
        tall = p.copy()  # the body is taller than thick
        stretch = 1.0 + 0.5 * bump(p[:, 1], w)
        tall[:, 2] = cz + (p[:, 2] - cz) / stretch
        bar = rounded_chain(tall, path, thickness)
        horn = rounded_chain(
            p, np.array([[cx - 4.0, w - 0.5, cz + 2.0], [cx - 6.5, w + 1.0, cz + 7.5]]), np.array([1.8, 1.1])
        )
        return smooth_union(bar, horn, 2.5)


def gum_ridge(points: Array, arch: DentalArch, depth: float, lean: float, core: Array | None = None) -> Array:
    """Gum around an arch, in bite, (n,): a rounded ridge with papillae between the teeth.

    depth: from the necks to its base [mm]; lean: how much its middle moves inward per mm of depth.
    core: distance to what else the gum covers between crest and base, (n,).
    """
    along, across = arch.path.coordinates(points[:, :2])
    up = arch.up
    middles = np.array(arch.middles)
    widths = np.array([t.width for t in arch.teeth])
    s = np.abs(along)
    beyond = smoothstep(arch.end - 2.0, arch.end + 7.0, s)
    phase = np.interp(s, np.concatenate([[0.0], np.cumsum(widths)]), np.arange(len(widths) + 1.0))
    papilla = 1.2 * (2.0 * np.abs(phase - np.floor(phase) - 0.5)) ** 2
    crest = arch.neck_level(np.minimum(s, arch.end)) + up * (0.5 + papilla * (1.0 - beyond) - 2.5 * beyond)
    base = arch.base_level(s) - up * depth
    above_crest = up * (points[:, 2] - crest)
    deep = np.maximum(up * (arch.base_level(s) - points[:, 2]), 0.0)  # mm below the gum line
    facing = np.tan(np.radians(np.interp(s, middles, [t.lean for t in arch.teeth])))
    half = np.interp(s, middles, [t.depth / 2.0 for t in arch.teeth]) + 1.0
    front = np.interp(s, [0.0, middles[2], middles[3]], [-0.8, -0.6, 0.0])
    middle = front - facing * np.minimum(deep, 3.0) - lean * deep
    wall = np.abs(across - middle) - half + 0.22 * np.maximum(deep - 2.5, 0.0)
    ridge = smooth_intersection(wall, above_crest, 4.0)
    if core is not None:
        ridge = smooth_union(ridge, core, 2.0)
    ridge = smooth_intersection(ridge, up * (base - points[:, 2]), 3.0)
    return smooth_intersection(ridge, s - (arch.end + 5.0), 6.0)
