"""Signed-distance shapes and their smooth combination, in mm, negative inside.

Distances are exact for the primitives that say so and first-order approximations elsewhere; they are meant
for blending and for surfacing, which only needs the zero level and a gradient of about unit length.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicSpline, PchipInterpolator, RectBivariateSpline
from scipy.spatial import cKDTree

Array = NDArray[np.float64]


def smooth_union(a: Array, b: Array, width: float) -> Array:
    """Union with a fillet about `width` wide (polynomial smooth minimum; Quilez)."""
    h = np.maximum(width - np.abs(a - b), 0.0) / width
    return np.minimum(a, b) - h * h * width / 4.0


def smooth_intersection(a: Array, b: Array, width: float) -> Array:
    """Intersection with its edge rounded over `width`."""
    return -smooth_union(-a, -b, width)


def smooth_difference(a: Array, b: Array, width: float) -> Array:
    """a without b, with the edge rounded over `width`."""
    return smooth_intersection(a, -b, width)


def smoothstep(low: float, high: float, x: Array) -> Array:
    """0 below `low`, 1 above `high`, C1 between; falls instead when low > high."""
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def bump(x: Array, width: float) -> Array:
    """Gaussian exp(-(x / width)^2)."""
    return np.exp(-((x / width) ** 2))


def sphere(points: Array, centre: Array | tuple[float, float, float], radius: float) -> Array:
    """Exact distance to a sphere, (n,)."""
    return np.linalg.norm(points - np.asarray(centre), axis=1) - radius


def ellipsoid(points: Array, centre: tuple[float, float, float], radii: tuple[float, float, float]) -> Array:
    """Distance to an axis-aligned ellipsoid, first order near the surface, (n,)."""
    q = points - np.asarray(centre)
    r = np.asarray(radii)
    inner = np.linalg.norm(q / r, axis=1)
    slope = np.linalg.norm(q / r**2, axis=1)
    return inner * (inner - 1.0) / np.maximum(slope, 1e-9)


def rounded_chain(points: Array, path: Array, radii: Array) -> Array:
    """Distance to the union of round cones along a polyline, (n,); exact where the radius is constant.

    path: (k, 3); radii: (k,), interpolated along each piece.
    """
    best = np.full(len(points), np.inf)
    for a, b, r, s in zip(path[:-1], path[1:], radii[:-1], radii[1:], strict=True):
        edge = b - a
        t = np.clip((points - a) @ edge / max(float(edge @ edge), 1e-12), 0.0, 1.0)
        distance = np.linalg.norm(points - a - t[:, None] * edge, axis=1)
        best = np.minimum(best, distance - (r + t * (s - r)))
    return best


def rounded_extrusion(profile: Array, beside: Array, radius: Array | float) -> Array:
    """Body whose cross-sections are a profile and a width, with its edges rounded by `radius`.

    profile: distance to the two-dimensional profile, (n,); beside: distance beyond the half-width, (n,).
    """
    p, q = profile + radius, beside + radius
    outside = np.sqrt(np.maximum(p, 0.0) ** 2 + np.maximum(q, 0.0) ** 2)
    return np.minimum(np.maximum(p, q), 0.0) + outside - radius


def superellipse(x: Array, y: Array, a: Array | float, b: Array | float, power: float) -> Array:
    """Distance to |x/a|^p + |y/b|^p = 1, first order near the curve, (n,)."""
    u, v = np.abs(x) / a, np.abs(y) / b
    norm = np.maximum((u**power + v**power), 1e-12) ** (1.0 / power)
    slope = norm ** (1.0 - power) * np.sqrt((u ** (power - 1.0) / a) ** 2 + (v ** (power - 1.0) / b) ** 2)
    return (norm - 1.0) / np.maximum(slope, 1.0 / np.maximum(a, b) * 0.5)


def curve_through(knots: Array | Sequence[tuple[float, ...]], closed: bool = False, count: int = 400) -> Array:
    """Points of the chord-length cubic spline through `knots` (k, d), evenly in parameter, (count, d)."""
    points = np.asarray(knots, dtype=np.float64)
    if closed:
        points = np.concatenate([points, points[:1]])
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1) ** 0.5)])
    spline = CubicSpline(length, points, bc_type="periodic" if closed else "natural")
    return spline(np.linspace(0.0, length[-1], count + closed)[:count])


def monotone(x: list[float], y: list[float]) -> Callable[[Array], Array]:
    """Shape-preserving curve y(x) through given points (x increasing), constant beyond its ends."""
    curve = PchipInterpolator(x, y, extrapolate=True)
    low, high = x[0], x[-1]
    return lambda at: curve(np.clip(at, low, high))


@dataclass(frozen=True, eq=False)
class PlanarField:
    """Signed distance to a closed smooth outline in a plane, sampled once and read by a bicubic spline.

    outline: (k, 2), closed, either orientation; margin, step: extent and step of the sampled grid [mm].
    """

    outline: Array
    margin: float = 25.0
    step: float = 0.6
    _spline: RectBivariateSpline = field(init=False, repr=False)

    def __post_init__(self) -> None:
        low, high = self.outline.min(axis=0) - self.margin, self.outline.max(axis=0) + self.margin
        axes = [np.arange(low[i], high[i] + self.step, self.step) for i in range(2)]
        grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)
        values = outline_distance(grid, self.outline).reshape(len(axes[0]), len(axes[1]))
        object.__setattr__(self, "_spline", RectBivariateSpline(*axes, values, kx=3, ky=3))

    def __call__(self, u: Array, v: Array) -> Array:
        """Distance at (u, v), (n,); beyond the grid, that of the grid's edge plus the way there."""
        (u0, u1), (v0, v1) = ((k[0], k[-1]) for k in self._spline.get_knots())
        inside_u, inside_v = np.clip(u, u0, u1), np.clip(v, v0, v1)
        return self._spline.ev(inside_u, inside_v) + np.hypot(u - inside_u, v - inside_v)


def outline_distance(points: Array, outline: Array) -> Array:
    """Exact signed distance of points (n, 2) to a closed polygon (k, 2), (n,)."""
    start, end = outline, np.roll(outline, -1, axis=0)
    distance = np.full(len(points), np.inf)
    inside = np.zeros(len(points), dtype=bool)
    for a, b in zip(start, end, strict=True):
        edge, offset = b - a, points - a
        t = np.clip(offset @ edge / max(float(edge @ edge), 1e-12), 0.0, 1.0)
        distance = np.minimum(distance, ((offset - t[:, None] * edge) ** 2).sum(axis=1))
        straddles = (a[1] > points[:, 1]) != (b[1] > points[:, 1])
        if straddles.any() and b[1] != a[1]:
            inside ^= straddles & (points[:, 0] < a[0] + edge[0] * (points[:, 1] - a[1]) / edge[1])
    return np.where(inside, -1.0, 1.0) * np.sqrt(distance)


@dataclass(frozen=True, eq=False)
class PathFrame:
    """Coordinates of points along and across an open curve in the horizontal plane.

    path: (k, 2) points of the curve, close together, that runs from the left end over the front to the
        right end of an arch; across is positive outward (away from the arch's middle).
    """

    path: Array
    _tree: cKDTree = field(init=False, repr=False)
    _length: Array = field(init=False, repr=False)

    def __post_init__(self) -> None:
        steps = np.linalg.norm(np.diff(self.path, axis=0), axis=1)
        object.__setattr__(self, "_length", np.concatenate([[0.0], np.cumsum(steps)]))
        object.__setattr__(self, "_tree", cKDTree(self.path))

    @property
    def length(self) -> float:
        return float(self._length[-1])

    def coordinates(self, points: Array) -> tuple[Array, Array]:
        """(along, across) of points (n, 2): length from the middle of the curve, left positive; distance.

        Beyond an end of the curve, `along` goes on along the end's tangent.
        """
        _, nearest = self._tree.query(points)
        i = np.clip(nearest, 1, len(self.path) - 2)
        tangent = self.path[i + 1] - self.path[i - 1]
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        offset = points - self.path[i]
        forward = (offset * tangent).sum(axis=1)
        along = self._length[i] + forward
        outward = np.stack([-tangent[:, 1], tangent[:, 0]], axis=1)
        return self.length / 2.0 - along, (offset * outward).sum(axis=1)

    def at(self, along: float) -> tuple[Array, Array]:
        """Point (2,) and unit tangent (2,) towards the left end, `along` from the middle."""
        s = self.length / 2.0 - along
        point = np.array([np.interp(s, self._length, self.path[:, a]) for a in range(2)])
        ahead = np.array([np.interp(s - 0.5, self._length, self.path[:, a]) for a in range(2)])
        behind = np.array([np.interp(s + 0.5, self._length, self.path[:, a]) for a in range(2)])
        tangent = ahead - behind
        return point, tangent / np.linalg.norm(tangent)
