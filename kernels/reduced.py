"""Kernels on reduced coordinates Q (columns, 3): u = B Q, gradient = H Q, stacked over elements.

H is the gradient operator of the cubature elements, (3 * element_count, columns): row 3 e + j holds
the derivative along X_j of every basis column in element e. The reduced force is H^T stress (Luo 2017,
Eq. 8) and the (i, m) block of the reduced stiffness H^T diag(tangent_im) H (Eq. 9). The
solvers take the products with H and B from `kernels.dense`; `gradient`, `force`, `stiffness` and `skin` here, one
thread a result, are their plain reference in tests and benchmarks.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from .precision import precision

COMPONENT_PAIRS = ((0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2))
"""The blocks (i, m) of the symmetric reduced stiffness that are computed, in storage order."""


@cache
def reduced_kernels(precision_name: str) -> SimpleNamespace:
    """Kernels `gradient`, `force`, `tangent_times_gradient`, `stiffness` and `skin` of one precision."""
    p = precision(precision_name)
    scalar, vec3, mat33 = p.scalar, p.vec3, p.mat33

    @wp.kernel(module="unique")
    def gradient(
        gradient_operator: wp.array(dtype=scalar, ndim=2),
        coordinates: wp.array(dtype=vec3),
        gradient_out: wp.array(dtype=mat33),
    ):
        """One thread writes one cubature element's displacement gradient H_e Q."""
        e = wp.tid()
        result = mat33()
        for k in range(coordinates.shape[0]):
            row = vec3(gradient_operator[3 * e, k], gradient_operator[3 * e + 1, k], gradient_operator[3 * e + 2, k])
            result += wp.outer(row, coordinates[k])
        gradient_out[e] = result

    @wp.kernel(module="unique")
    def force(
        gradient_operator: wp.array(dtype=scalar, ndim=2),
        stress: wp.array(dtype=mat33),
        force_out: wp.array(dtype=vec3),
    ):
        """One thread writes one column's reduced internal force, summed over the cubature elements."""
        k = wp.tid()
        result = vec3()
        for e in range(stress.shape[0]):
            row = vec3(gradient_operator[3 * e, k], gradient_operator[3 * e + 1, k], gradient_operator[3 * e + 2, k])
            result += wp.transpose(stress[e]) * row
        force_out[k] = result

    @wp.kernel(module="unique")
    def tangent_times_gradient(
        gradient_operator: wp.array(dtype=scalar, ndim=2),
        tangent: wp.array(dtype=mat33, ndim=3),
        product_out: wp.array(dtype=scalar, ndim=3),
    ):
        """One thread writes tangent_im H for one element and column: product_out[3 e + j, pair, k]."""
        e, k = wp.tid()
        row = vec3(gradient_operator[3 * e, k], gradient_operator[3 * e + 1, k], gradient_operator[3 * e + 2, k])
        pair = int(0)
        for i in range(3):
            for m in range(i, 3):
                column = tangent[e, i, m] * row
                for j in range(3):
                    product_out[3 * e + j, pair, k] = column[j]
                pair += 1

    @wp.kernel(module="unique")
    def stiffness(
        gradient_operator: wp.array(dtype=scalar, ndim=2),
        product: wp.array(dtype=scalar, ndim=3),
        blocks_out: wp.array(dtype=scalar, ndim=3),
    ):
        """One thread writes one entry (k, pair, l) of the reduced stiffness blocks H^T (tangent H)."""
        k, pair, l = wp.tid()
        result = scalar(0.0)
        for row in range(gradient_operator.shape[0]):
            result += gradient_operator[row, k] * product[row, pair, l]
        blocks_out[k, pair, l] = result

    @wp.kernel(module="unique")
    def skin(
        rest: wp.array(dtype=vec3),
        basis: wp.array(dtype=scalar, ndim=2),
        coordinates: wp.array(dtype=vec3),
        position_out: wp.array(dtype=vec3),
    ):
        """One thread writes one vertex: rest position plus its row of the basis times Q."""
        v = wp.tid()
        result = rest[v]
        for k in range(coordinates.shape[0]):
            result += basis[v, k] * coordinates[k]
        position_out[v] = result

    return SimpleNamespace(
        gradient=gradient,
        force=force,
        tangent_times_gradient=tangent_times_gradient,
        stiffness=stiffness,
        skin=skin,
    )
