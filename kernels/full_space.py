"""Kernels on the whole mesh: displacement gradients from nodes, forces and stiffness back to nodes.

Sums are gathered by the thread that owns the result, so that they have the same rounding in every run.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from .precision import precision


@cache
def full_space_kernels(precision_name: str) -> SimpleNamespace:
    """Kernels `displacement_gradient`, `gather_force` and `gather_stiffness` of one precision."""
    p = precision(precision_name)
    scalar, vec3, mat33 = p.scalar, p.vec3, p.mat33

    @wp.kernel(module="unique")
    def displacement_gradient(
        displacement: wp.array(dtype=vec3),
        tets: wp.array(dtype=wp.int32, ndim=2),
        shape_gradients: wp.array(dtype=vec3, ndim=2),
        gradient_out: wp.array(dtype=mat33),
    ):
        """One thread writes one element's displacement gradient, [j, i] = du_i/dX_j."""
        e = wp.tid()
        gradient = mat33()
        for a in range(4):
            gradient += wp.outer(shape_gradients[e, a], displacement[tets[e, a]])
        gradient_out[e] = gradient

    @wp.kernel(module="unique")
    def gather_force(
        stress: wp.array(dtype=mat33),
        shape_gradients: wp.array(dtype=vec3, ndim=2),
        corner_starts: wp.array(dtype=wp.int32),
        corners: wp.array(dtype=wp.int32),
        force_out: wp.array(dtype=vec3),
    ):
        """One thread sums one node's internal force (the energy's gradient) over the corners 4 e + a in it."""
        n = wp.tid()
        force = vec3()
        for k in range(corner_starts[n], corner_starts[n + 1]):
            e = corners[k] / 4
            force += wp.transpose(stress[e]) * shape_gradients[e, corners[k] - 4 * e]
        force_out[n] = force

    @wp.kernel(module="unique")
    def gather_stiffness(
        tangent: wp.array(dtype=mat33, ndim=3),
        shape_gradients: wp.array(dtype=vec3, ndim=2),
        pair_starts: wp.array(dtype=wp.int32),
        pairs: wp.array(dtype=wp.int32),
        block_out: wp.array(dtype=mat33),
    ):
        """One thread sums one 3x3 block of the stiffness over the pairs of corners 16 e + 4 a + b that share it."""
        block = wp.tid()
        K = mat33()
        for k in range(pair_starts[block], pair_starts[block + 1]):
            e = pairs[k] / 16
            pair = pairs[k] - 16 * e
            ga = shape_gradients[e, pair / 4]
            gb = shape_gradients[e, pair - 4 * (pair / 4)]
            for i in range(3):
                for m in range(3):
                    K[i, m] += wp.dot(ga, tangent[e, i, m] * gb)
        block_out[block] = K

    return SimpleNamespace(
        displacement_gradient=displacement_gradient,
        gather_force=gather_force,
        gather_stiffness=gather_stiffness,
        scalar=scalar,
    )
