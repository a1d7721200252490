"""Contact of points of the tongue with rigid bodies in the jaw frame and in the head frame, many tongues at once.

A point of area A at signed distance phi from the bodies of one frame has the depth delta = max(0, -phi - allowed),
where `allowed` is how deep it lies at rest. Its damped spring of stiffness k = stiffness per area times A and
damping c = damping * k never pulls: the force along the outward normal is

    max(0, k delta + c (delta - delta0) / h) = (k + c / h) max(0, delta - onset),  onset = c / h / (k + c / h) delta0

with delta0 the depth at the start of the step, so that a step's incremental potential is the convex, once
continuously differentiable (k + c / h) / 2 max(0, delta - onset)^2. `damping_over_step` is damping / h.

Arrays: points in the jaw frame; [p, i, t] is component i of point p of tongue t; [f, p, t] belongs to frame f,
0 the jaw's and 1 the head's; a jaw pose takes jaw to head coordinates. Forces are gradients of the potential,
like internal forces, and so point into the bodies.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from .precision import precision
from .signed_distance import distance_functions


@cache
def contact_kernels(precision_name: str) -> SimpleNamespace:
    """Kernels `depth`, `force`, `energy`, `stiffness_product` and `summary` of one precision."""
    p = precision(precision_name)
    scalar, vec3, mat33 = p.scalar, p.vec3, p.mat33
    functions = distance_functions(precision_name)
    Grid, vec4 = functions.Grid, functions.vec4
    signed_distance, may_touch = functions.signed_distance, functions.may_touch

    @wp.func
    def depth_and_gradient(grid: Grid, point: vec3, allowed: scalar):
        """Depth [m] beyond the allowed one and its gradient, (depth, x, y, z); zero where there is no contact."""
        if not may_touch(grid, point):
            return vec4()
        distance = signed_distance(grid, point)
        depth = -distance[0] - allowed
        if depth <= scalar(0.0):
            return vec4()
        return vec4(depth, -distance[1], -distance[2], -distance[3])

    @wp.func
    def point_of(
        rest: wp.array(dtype=scalar, ndim=2), displacement: wp.array(dtype=scalar, ndim=3), point: int, tongue: int
    ):
        return vec3(
            rest[point, 0] + displacement[point, 0, tongue],
            rest[point, 1] + displacement[point, 1, tongue],
            rest[point, 2] + displacement[point, 2, tongue],
        )

    @wp.func
    def push(depth: scalar, depth_start: scalar, damping_over_step: scalar):
        """How far a damped spring of unit stiffness is beyond its onset, stretched by the damping."""
        onset = damping_over_step / (scalar(1.0) + damping_over_step) * depth_start
        return (scalar(1.0) + damping_over_step) * wp.max(scalar(0.0), depth - onset)

    @wp.kernel(module="unique")
    def depth(
        rest: wp.array(dtype=scalar, ndim=2),
        displacement: wp.array(dtype=scalar, ndim=3),
        rotation: wp.array(dtype=mat33),
        translation: wp.array(dtype=vec3),
        jaw: Grid,
        head: Grid,
        allowed: wp.array(dtype=scalar, ndim=2),
        depth_out: wp.array(dtype=scalar, ndim=3),
    ):
        """One thread writes the depth of one point of one tongue in the bodies of both frames."""
        n, t = wp.tid()
        x = point_of(rest, displacement, n, t)
        in_jaw = depth_and_gradient(jaw, x, allowed[0, n])
        in_head = depth_and_gradient(head, rotation[t] * x + translation[t], allowed[1, n])
        depth_out[0, n, t] = in_jaw[0]
        depth_out[1, n, t] = in_head[0]

    @wp.kernel(module="unique")
    def force(
        rest: wp.array(dtype=scalar, ndim=2),
        displacement: wp.array(dtype=scalar, ndim=3),
        rotation: wp.array(dtype=mat33),
        translation: wp.array(dtype=vec3),
        jaw: Grid,
        head: Grid,
        allowed: wp.array(dtype=scalar, ndim=2),
        stiffness: wp.array(dtype=scalar),
        depth_start: wp.array(dtype=scalar, ndim=3),
        damping_over_step: scalar,
        force_out: wp.array(dtype=scalar, ndim=3),
        stiffness_out: wp.array(dtype=scalar, ndim=3),
        depth_out: wp.array(dtype=scalar, ndim=3),
    ):
        """One thread writes one point's force, Gauss-Newton stiffness (xx, xy, xz, yy, yz, zz) and depths."""
        n, t = wp.tid()
        x = point_of(rest, displacement, n, t)
        in_jaw = depth_and_gradient(jaw, x, allowed[0, n])
        in_head = depth_and_gradient(head, rotation[t] * x + translation[t], allowed[1, n])
        depth_out[0, n, t] = in_jaw[0]
        depth_out[1, n, t] = in_head[0]
        jaw_normal = vec3(in_jaw[1], in_jaw[2], in_jaw[3])
        head_normal = wp.transpose(rotation[t]) * vec3(in_head[1], in_head[2], in_head[3])
        jaw_push = push(in_jaw[0], depth_start[0, n, t], damping_over_step)
        head_push = push(in_head[0], depth_start[1, n, t], damping_over_step)
        total = stiffness[n] * (jaw_push * jaw_normal + head_push * head_normal)
        slope = stiffness[n] * (scalar(1.0) + damping_over_step)
        jaw_slope = wp.where(jaw_push > scalar(0.0), slope, scalar(0.0))
        head_slope = wp.where(head_push > scalar(0.0), slope, scalar(0.0))
        pair = int(0)
        for i in range(3):
            force_out[n, i, t] = total[i]
            for m in range(i, 3):
                value = jaw_slope * jaw_normal[i] * jaw_normal[m] + head_slope * head_normal[i] * head_normal[m]
                stiffness_out[n, pair, t] = value
                pair += 1

    @wp.kernel(module="unique")
    def energy(
        stiffness: wp.array(dtype=scalar),
        depth: wp.array(dtype=scalar, ndim=3),
        depth_start: wp.array(dtype=scalar, ndim=3),
        damping_over_step: scalar,
        energy_out: wp.array(dtype=scalar),
    ):
        """One thread sums the incremental potential [J] of one tongue's contacts."""
        t = wp.tid()
        result = scalar(0.0)
        for f in range(depth.shape[0]):
            for n in range(depth.shape[1]):
                pushed = push(depth[f, n, t], depth_start[f, n, t], damping_over_step)
                result += stiffness[n] * pushed * pushed
        energy_out[t] = scalar(0.5) * result / (scalar(1.0) + damping_over_step)

    @wp.kernel(module="unique")
    def stiffness_product(
        stiffness: wp.array(dtype=scalar, ndim=3),
        direction: wp.array(dtype=scalar, ndim=3),
        product_out: wp.array(dtype=scalar, ndim=3),
    ):
        """One thread applies one point's stiffness to its displacement in a direction."""
        n, t = wp.tid()
        x, y, z = direction[n, 0, t], direction[n, 1, t], direction[n, 2, t]
        xy, xz, yz = stiffness[n, 1, t], stiffness[n, 2, t], stiffness[n, 4, t]
        product_out[n, 0, t] = stiffness[n, 0, t] * x + xy * y + xz * z
        product_out[n, 1, t] = xy * x + stiffness[n, 3, t] * y + yz * z
        product_out[n, 2, t] = xz * x + yz * y + stiffness[n, 5, t] * z

    @wp.kernel(module="unique")
    def summary(
        depth: wp.array(dtype=scalar, ndim=3),
        deepest_out: wp.array(dtype=scalar),
        contact_count_out: wp.array(dtype=wp.int32),
    ):
        """One thread adds one point of one tongue to that tongue's greatest depth and number of contacts."""
        n, t = wp.tid()
        deepest = wp.max(depth[0, n, t], depth[1, n, t])
        if deepest > scalar(0.0):
            wp.atomic_max(deepest_out, t, deepest)
            wp.atomic_add(contact_count_out, t, 1)

    return SimpleNamespace(
        depth=depth, force=force, energy=energy, stiffness_product=stiffness_product, summary=summary
    )
