"""Signed distance to rigid bodies: built from closed triangle meshes, read from a grid.

The grid's numbers are the coefficients of a triquadratic B-spline (27 around a point), so that the distance
and its gradient are continuous: with trilinear interpolation the contact force would jump at every cell face
and Newton's method would not settle there.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from .precision import precision

FAR = 1.0
"""Distance [m] that points outside a grid have: they touch nothing."""

TOUCH_REACH = 3.0
"""A point whose nearest coefficient is more than so many spacings lies outside: the spline weighs coefficients
up to 1.5 spacings away along each axis, and a distance changes by no more than the way."""


@cache
def distance_functions(precision_name: str) -> SimpleNamespace:
    """The struct `Grid`, the Warp functions `signed_distance` and `may_touch`, the kernel `sample`."""
    p = precision(precision_name)
    scalar, vec3 = p.scalar, p.vec3
    vec4 = wp.types.vector(length=4, dtype=scalar)

    @wp.struct
    class Grid:
        """values: coefficients [m], (nx, ny, nz); lower: where the first one sits [m]; spacing [m]."""

        values: wp.array(dtype=wp.float32, ndim=3)
        lower: vec3
        spacing: scalar

    @wp.func
    def nearest(grid: Grid, point: vec3):
        """Indices of the coefficient nearest to a point, clamped so that they fit into integers."""
        limit = scalar(1.0e6)
        s = (point - grid.lower) / grid.spacing
        i = int(wp.floor(wp.clamp(s[0], -limit, limit) + scalar(0.5)))
        j = int(wp.floor(wp.clamp(s[1], -limit, limit) + scalar(0.5)))
        k = int(wp.floor(wp.clamp(s[2], -limit, limit) + scalar(0.5)))
        return wp.vec3i(i, j, k)

    @wp.func
    def inside_grid(grid: Grid, c: wp.vec3i):
        """Whether the coefficient has neighbours on all sides."""
        x = c[0] >= 1 and c[0] < grid.values.shape[0] - 1
        y = c[1] >= 1 and c[1] < grid.values.shape[1] - 1
        z = c[2] >= 1 and c[2] < grid.values.shape[2] - 1
        return x and y and z

    @wp.func
    def may_touch(grid: Grid, point: vec3):
        """Whether a point can lie inside a body; reads one number."""
        c = nearest(grid, point)
        if not inside_grid(grid, c):
            return False
        return scalar(grid.values[c[0], c[1], c[2]]) < scalar(TOUCH_REACH) * grid.spacing

    @wp.func
    def spline(t: scalar):
        """The three quadratic B-splines at t in [-1/2, 1/2] from their middle one."""
        half = scalar(0.5)
        return vec3(half * (half - t) * (half - t), scalar(0.75) - t * t, half * (half + t) * (half + t))

    @wp.func
    def spline_slope(t: scalar):
        """Their derivatives."""
        return vec3(t - scalar(0.5), scalar(-2.0) * t, t + scalar(0.5))

    @wp.func
    def signed_distance(grid: Grid, point: vec3):
        """Signed distance [m], positive outside, and its gradient: (distance, x, y, z)."""
        c = nearest(grid, point)
        if not inside_grid(grid, c):
            return vec4(scalar(FAR), scalar(0.0), scalar(0.0), scalar(0.0))
        t = (point - grid.lower) / grid.spacing - vec3(scalar(c[0]), scalar(c[1]), scalar(c[2]))
        wx, wy, wz = spline(t[0]), spline(t[1]), spline(t[2])
        sx, sy, sz = spline_slope(t[0]), spline_slope(t[1]), spline_slope(t[2])
        result = vec4()
        for a in range(3):
            for b in range(3):
                line = vec3(
                    scalar(grid.values[c[0] + a - 1, c[1] + b - 1, c[2] - 1]),
                    scalar(grid.values[c[0] + a - 1, c[1] + b - 1, c[2]]),
                    scalar(grid.values[c[0] + a - 1, c[1] + b - 1, c[2] + 1]),
                )
                value = wp.dot(line, wz)
                result += vec4(
                    wx[a] * wy[b] * value,
                    sx[a] * wy[b] * value,
                    wx[a] * sy[b] * value,
                    wx[a] * wy[b] * wp.dot(line, sz),
                )
        slope = scalar(1.0) / grid.spacing
        return vec4(result[0], slope * result[1], slope * result[2], slope * result[3])

    @wp.kernel(module="unique")
    def sample(grid: Grid, points: wp.array(dtype=vec3), distance_out: wp.array(dtype=vec4)):
        """One thread reads the signed distance and its gradient at one point."""
        i = wp.tid()
        distance_out[i] = signed_distance(grid, points[i])

    return SimpleNamespace(Grid=Grid, signed_distance=signed_distance, may_touch=may_touch, sample=sample, vec4=vec4)


@cache
def mesh_distance_kernel() -> wp.Kernel:
    """The kernel `mesh_distance`, in single precision as Warp's meshes are."""

    @wp.kernel(module="unique")
    def mesh_distance(
        mesh: wp.uint64,
        points: wp.array(dtype=wp.vec3f),
        reach: wp.float32,
        distance_out: wp.array(dtype=wp.float32),
    ):
        """One thread lowers one point's signed distance to that of a closed mesh; inside by winding number."""
        i = wp.tid()
        query = wp.mesh_query_point_sign_winding_number(mesh, points[i], reach, 2.0, 0.5)
        if query.result:
            nearest = wp.mesh_eval_position(mesh, query.face, query.u, query.v)
            distance_out[i] = wp.min(distance_out[i], query.sign * wp.length(points[i] - nearest))

    return mesh_distance
