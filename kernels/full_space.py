"""Kernels on the whole mesh: displacement gradients from nodes, forces and stiffness back to nodes."""

from functools import cache
from types import SimpleNamespace

import warp as wp

from .precision import precision


@cache
def full_space_kernels(precision_name: str) -> SimpleNamespace:
    """Kernels `displacement_gradient`, `scatter_force` and `scatter_stiffness` of one precision."""
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
    def scatter_force(
        stress: wp.array(dtype=mat33),
        tets: wp.array(dtype=wp.int32, ndim=2),
        shape_gradients: wp.array(dtype=vec3, ndim=2),
        force_out: wp.array(dtype=vec3),
    ):
        """One thread adds one element's internal force (the energy's gradient) to its four nodes."""
        e = wp.tid()
        for a in range(4):
            wp.atomic_add(force_out, tets[e, a], wp.transpose(stress[e]) * shape_gradients[e, a])

    @wp.kernel(module="unique")
    def scatter_stiffness(
        tangent: wp.array(dtype=mat33, ndim=3),
        shape_gradients: wp.array(dtype=vec3, ndim=2),
        block_of_pair: wp.array(dtype=wp.int32, ndim=3),
        block_out: wp.array(dtype=mat33),
    ):
        """One thread adds one element's stiffness to the 3x3 blocks of its 16 node pairs; -1 is skipped."""
        e = wp.tid()
        for a in range(4):
            ga = shape_gradients[e, a]
            for b in range(4):
                block = block_of_pair[e, a, b]
                if block >= 0:
                    gb = shape_gradients[e, b]
                    K = mat33()
                    for i in range(3):
                        for m in range(3):
                            K[i, m] = wp.dot(ga, tangent[e, i, m] * gb)
                    wp.atomic_add(block_out, block, K)

    return SimpleNamespace(
        displacement_gradient=displacement_gradient,
        scatter_force=scatter_force,
        scatter_stiffness=scatter_stiffness,
        scalar=scalar,
    )
