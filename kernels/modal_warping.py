"""Modal warping at the nodes: warped positions, sensors and rotated loads (Choi and Ko 2005).

A linear displacement a of a node, seen as measured in a frame that turns steadily from rest to the rotation
vector w, carries the node to

    u = Rbar(w) a,   Rbar(w) = integral over s in [0, 1] of exp(s [w]) = I + c1 [w] + c2 [w]^2,
    c1 = (1 - cos t) / t^2,   c2 = (1 - sin t / t) / t^2,   t = |w|,

which is Choi and Ko's mean rotation. For t^2 < 1 both coefficients are power series in t^2, which are
accurate where the quotients cancel and cheaper than sine and cosine everywhere.

Arrays of points have the shape (points, 3, tongue_count); the tongue is the last index and contiguous. The
linear part of the motion interleaves the nodes' two vectors: point 2 k is a and point 2 k + 1 is w of node k.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from .precision import precision

SERIES_LIMIT = 1.0
"""Squared angle [rad^2] below which the series are used; eight terms are exact to rounding there."""


@cache
def modal_warping_kernels(precision_name: str) -> SimpleNamespace:
    """Kernels `linear_part`, `warp`, `rotated_load` and `sensor_warp` of one precision."""
    p = precision(precision_name)
    scalar, vec3 = p.scalar, p.vec3
    one, half, limit = p.scalar(1.0), p.scalar(0.5), p.scalar(SERIES_LIMIT)

    @wp.func
    def point(points: wp.array(dtype=scalar, ndim=3), n: int, tongue: int):
        return vec3(points[n, 0, tongue], points[n, 1, tongue], points[n, 2, tongue])

    @wp.func
    def sine_coefficient(s: scalar):
        """c1 of the squared angle s: sum over k of (-s)^k / (2 k + 2)!."""
        if s >= limit:
            return (one - wp.cos(wp.sqrt(s))) / s
        r = one - s / scalar(182.0) * (one - s / scalar(240.0))
        r = one - s / scalar(56.0) * (one - s / scalar(90.0) * (one - s / scalar(132.0) * r))
        return half * (one - s / scalar(12.0) * (one - s / scalar(30.0) * r))

    @wp.func
    def square_coefficient(s: scalar):
        """c2 of the squared angle s: sum over k of (-s)^k / (2 k + 3)!."""
        if s >= limit:
            t = wp.sqrt(s)
            return (one - wp.sin(t) / t) / s
        r = one - s / scalar(210.0) * (one - s / scalar(272.0))
        r = one - s / scalar(72.0) * (one - s / scalar(110.0) * (one - s / scalar(156.0) * r))
        return (one - s / scalar(20.0) * (one - s / scalar(42.0) * r)) / scalar(6.0)

    @wp.func
    def coefficient_slopes(s: scalar):
        """(dc1/ds, dc2/ds) of the squared angle s."""
        slope1, slope2 = scalar(0.0), scalar(0.0)
        if s >= limit:
            t = wp.sqrt(s)
            sinc = wp.sin(t) / t
            slope1 = (half * sinc - (one - wp.cos(t)) / s) / s
            slope2 = half * (scalar(3.0) * sinc - wp.cos(t) - scalar(2.0)) / (s * s)
        else:
            term1, term2 = -one / scalar(24.0), -one / scalar(120.0)  # (-1)^k s^(k-1) / (2k+2)! and / (2k+3)!
            for k in range(1, 9):
                order = scalar(k)
                slope1 += order * term1
                slope2 += order * term2
                even = scalar(2.0) * order + scalar(4.0)
                term1 = -term1 * s / ((even - one) * even)
                term2 = -term2 * s / (even * (even + one))
        return slope1, slope2

    @wp.func
    def mean_rotated(w: vec3, a: vec3):
        """Rbar(w) a."""
        s = wp.dot(w, w)
        turned = wp.cross(w, a)
        return a + sine_coefficient(s) * turned + square_coefficient(s) * wp.cross(w, turned)

    @wp.func
    def mean_rotated_slope(w: vec3, a: vec3):
        """Derivative of Rbar(w) a with respect to w."""
        s = wp.dot(w, w)
        c2 = square_coefficient(s)
        slope1, slope2 = coefficient_slopes(s)
        turned = wp.cross(w, a)
        along = scalar(2.0) * (slope1 * turned + slope2 * wp.cross(w, turned))
        across = -sine_coefficient(s) * wp.skew(a) - c2 * (wp.skew(turned) + wp.skew(w) * wp.skew(a))
        return wp.outer(along, w) + across

    @wp.kernel(module="unique")
    def linear_part(
        rows: wp.array(dtype=scalar, ndim=2),
        coordinates: wp.array(dtype=scalar, ndim=3),
        linear_out: wp.array(dtype=scalar, ndim=3),
    ):
        """One thread writes one component of a point (a or w of a node) of one tongue: its row times q."""
        n, i, tongue = wp.tid()
        result = scalar(0.0)
        for k in range(rows.shape[1]):
            result += rows[3 * n + i, k] * coordinates[k, 0, tongue]
        linear_out[n, i, tongue] = result

    @wp.kernel(module="unique")
    def warp(
        nodes: wp.array(dtype=wp.int32),
        rest: wp.array(dtype=vec3),
        linear: wp.array(dtype=scalar, ndim=3),
        position_out: wp.array(dtype=scalar, ndim=3),
    ):
        """One thread writes one moving node's warped position in one tongue, at its place among all nodes."""
        k, tongue = wp.tid()
        n = nodes[k]
        x = rest[n] + mean_rotated(point(linear, 2 * k + 1, tongue), point(linear, 2 * k, tongue))
        for i in range(3):
            position_out[n, i, tongue] = x[i]

    @wp.kernel(module="unique")
    def rotated_load(
        masses: wp.array(dtype=scalar),
        acceleration: wp.array(dtype=vec3),
        linear: wp.array(dtype=scalar, ndim=3),
        load_out: wp.array(dtype=scalar, ndim=3),
    ):
        """One thread writes one moving node's mass times its tongue's acceleration, turned back by exp([w])^T.

        load_out has the rows of `linear`: those of w are left as they are.
        """
        k, tongue = wp.tid()
        w = -point(linear, 2 * k + 1, tongue)
        s = wp.dot(w, w)
        turned = wp.cross(w, acceleration[tongue])
        # exp([w]) = I + (sin t / t) [w] + c1 [w]^2, and sin t / t = 1 - t^2 c2.
        load = acceleration[tongue] + (one - s * square_coefficient(s)) * turned
        load = masses[k] * (load + sine_coefficient(s) * wp.cross(w, turned))
        for i in range(3):
            load_out[2 * k, i, tongue] = load[i]

    @wp.kernel(module="unique")
    def sensor_warp(
        linear: wp.array(dtype=scalar, ndim=3),
        weights: wp.array(dtype=scalar, ndim=2),
        displacement_out: wp.array(dtype=scalar, ndim=3),
        slope_out: wp.array(dtype=scalar, ndim=4),
    ):
        """One thread warps the nodes under one sensor of one tongue and writes how that depends on them.

        The k-th node of sensor s, of weights[s, k], has the rows 2 (s node_count + k) and the next of `linear`.
        displacement_out[s]: the weighted mean of Rbar(w) a. slope_out[s, i, 6 k + c]: its derivative with
        respect to component c of (a, w) of that node.
        """
        s, tongue = wp.tid()
        u = vec3()
        for k in range(weights.shape[1]):
            row = 2 * (s * weights.shape[1] + k)
            a, w = point(linear, row, tongue), point(linear, row + 1, tongue)
            u += weights[s, k] * mean_rotated(w, a)
            slope = mean_rotated_slope(w, a)
            for c in range(3):
                unit = vec3()
                unit[c] = one
                column = mean_rotated(w, unit)
                for i in range(3):
                    slope_out[s, i, 6 * k + c, tongue] = weights[s, k] * column[i]
                    slope_out[s, i, 6 * k + 3 + c, tongue] = weights[s, k] * slope[i, c]
        for i in range(3):
            displacement_out[s, i, tongue] = u[i]

    return SimpleNamespace(linear_part=linear_part, warp=warp, rotated_load=rotated_load, sensor_warp=sensor_warp)
