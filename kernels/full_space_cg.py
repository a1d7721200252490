"""Conjugate gradients on a block-sparse matrix without reading a number back to the host.

The preconditioner is z = D^-1 r + Z A_c^-1 Z^T r with the diagonal blocks D of the matrix A and a coarse space Z of
piecewise trilinear functions, then projected onto the null space of the constraint rows J. Dot products are summed in a
fixed order: `LANES` threads sum every LANES-th number, `FOLDED` threads sum those, and whoever needs the
product sums the last few itself, which costs less than another launch. The loop's arithmetic is that of
solver/projected_cg.py. Everything is float64.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

LANES, FOLDED = 2048, 32


@cache
def full_space_cg_kernels() -> SimpleNamespace:
    """Kernels of one iteration, each named after what it writes."""
    vec3, mat33, scalar = wp.vec3d, wp.mat33d, wp.float64

    @wp.func
    def total(folded: wp.array(dtype=scalar)):
        result = scalar(0.0)
        for k in range(FOLDED):
            result += folded[k]
        return result

    @wp.kernel(module="unique")
    def add_diagonal(
        diagonal: wp.array(dtype=mat33), place: wp.array(dtype=wp.int32), blocks_out: wp.array(dtype=mat33)
    ):
        """One thread adds one node's 3x3 block to the matrix's diagonal."""
        n = wp.tid()
        blocks_out[place[n]] += diagonal[n]

    @wp.kernel(module="unique")
    def inverse_diagonal(
        blocks: wp.array(dtype=mat33), place: wp.array(dtype=wp.int32), inverse_out: wp.array(dtype=mat33)
    ):
        """One thread inverts one diagonal block of the matrix."""
        n = wp.tid()
        inverse_out[n] = wp.inverse(blocks[place[n]])

    @wp.kernel(module="unique")
    def matrix_product(
        blocks: wp.array(dtype=mat33),
        row_starts: wp.array(dtype=wp.int32),
        columns: wp.array(dtype=wp.int32),
        x: wp.array(dtype=vec3),
        product_out: wp.array(dtype=vec3),
    ):
        """One thread writes one node's row of A x."""
        n = wp.tid()
        result = vec3()
        for k in range(row_starts[n], row_starts[n + 1]):
            result += blocks[k] * x[columns[k]]
        product_out[n] = result

    @wp.kernel(module="unique")
    def weighted_sum(
        weights: wp.array(dtype=scalar),
        starts: wp.array(dtype=wp.int32),
        columns: wp.array(dtype=wp.int32),
        x: wp.array(dtype=vec3),
        sum_out: wp.array(dtype=vec3),
    ):
        """One thread writes one row of a scalar sparse matrix times nodal vectors: Z^T r."""
        n = wp.tid()
        result = vec3()
        for k in range(starts[n], starts[n + 1]):
            result += weights[k] * x[columns[k]]
        sum_out[n] = result

    @wp.kernel(module="unique")
    def dense_product(
        matrix: wp.array(dtype=scalar, ndim=2), x: wp.array(dtype=scalar), parts_out: wp.array(dtype=scalar, ndim=2)
    ):
        """One thread writes one part of one row of a symmetric matrix times a vector; neighbours share the part."""
        part, row = wp.tid()
        result = scalar(0.0)
        for k in range(part, x.shape[0], parts_out.shape[0]):
            result += matrix[k, row] * x[k]
        parts_out[part, row] = result

    @wp.kernel(module="unique")
    def sum_parts(parts: wp.array(dtype=scalar, ndim=2), sum_out: wp.array(dtype=scalar)):
        """One thread adds the parts of one row."""
        row = wp.tid()
        result = scalar(0.0)
        for part in range(parts.shape[0]):
            result += parts[part, row]
        sum_out[row] = result

    @wp.kernel(module="unique")
    def precondition(
        inverse_diagonal: wp.array(dtype=mat33),
        residual: wp.array(dtype=vec3),
        weights: wp.array(dtype=scalar),
        starts: wp.array(dtype=wp.int32),
        columns: wp.array(dtype=wp.int32),
        coarse: wp.array(dtype=vec3),
        direction_out: wp.array(dtype=vec3),
    ):
        """One thread writes one node of D^-1 r + Z y."""
        n = wp.tid()
        result = inverse_diagonal[n] * residual[n]
        for k in range(starts[n], starts[n + 1]):
            result += weights[k] * coarse[columns[k]]
        direction_out[n] = result

    @wp.kernel(module="unique")
    def constraint_product(
        rows: wp.array(dtype=vec3, ndim=2), x: wp.array(dtype=vec3), parts_out: wp.array(dtype=scalar, ndim=2)
    ):
        """One thread sums one part of one constraint row times x."""
        part, row = wp.tid()
        result = scalar(0.0)
        for n in range(part, x.shape[0], parts_out.shape[0]):
            result += wp.dot(rows[row, n], x[n])
        parts_out[part, row] = result

    @wp.kernel(module="unique")
    def constraint_force(
        rows: wp.array(dtype=vec3, ndim=2),
        solved_rows: wp.array(dtype=vec3, ndim=2),
        multipliers: wp.array(dtype=scalar),
        direction: wp.array(dtype=vec3),
        residual: wp.array(dtype=vec3),
    ):
        """One thread removes one node's share of the constraints from the direction and the residual, in place."""
        n = wp.tid()
        for row in range(multipliers.shape[0]):
            direction[n] = direction[n] - multipliers[row] * solved_rows[row, n]
            residual[n] = residual[n] - multipliers[row] * rows[row, n]

    @wp.kernel(module="unique")
    def accumulate(multipliers: wp.array(dtype=scalar), sum_out: wp.array(dtype=scalar)):
        """One thread adds one multiplier to its sum over the iterations."""
        row = wp.tid()
        sum_out[row] += multipliers[row]

    @wp.kernel(module="unique")
    def dot_lanes(a: wp.array(dtype=vec3), b: wp.array(dtype=vec3), lanes_out: wp.array(dtype=scalar)):
        """One thread sums every LANES-th term of a dot product."""
        lane = wp.tid()
        result = scalar(0.0)
        for n in range(lane, a.shape[0], LANES):
            result += wp.dot(a[n], b[n])
        lanes_out[lane] = result

    @wp.kernel(module="unique")
    def fold(lanes: wp.array(dtype=scalar), folded_out: wp.array(dtype=scalar)):
        """One thread sums every FOLDED-th lane."""
        lane = wp.tid()
        result = scalar(0.0)
        for k in range(lane, LANES, FOLDED):
            result += lanes[k]
        folded_out[lane] = result

    @wp.kernel(module="unique")
    def advance(
        decrease: wp.array(dtype=scalar),
        curvature: wp.array(dtype=scalar),
        p: wp.array(dtype=vec3),
        product: wp.array(dtype=vec3),
        x: wp.array(dtype=vec3),
        residual: wp.array(dtype=vec3),
        indefinite: wp.array(dtype=wp.int32),
    ):
        """One thread moves one node's x along p by r.z / p.Ap and its residual along -A p; notes p.Ap <= 0."""
        n = wp.tid()
        below, above = total(curvature), total(decrease)
        length = scalar(0.0)
        if below > scalar(0.0):
            length = above / below
        elif above > scalar(0.0) and n == 0:
            indefinite[0] = 1
        x[n] = x[n] + length * p[n]
        residual[n] = residual[n] - length * product[n]

    @wp.kernel(module="unique")
    def turn(
        current: wp.array(dtype=scalar),
        previous: wp.array(dtype=scalar),
        direction: wp.array(dtype=vec3),
        p: wp.array(dtype=vec3),
    ):
        """One thread writes one node's p = z + (r.z / previous r.z) p."""
        n = wp.tid()
        below = total(previous)
        share = scalar(0.0)
        if below > scalar(0.0):
            share = total(current) / below
        p[n] = direction[n] + share * p[n]

    return SimpleNamespace(
        add_diagonal=add_diagonal,
        inverse_diagonal=inverse_diagonal,
        matrix_product=matrix_product,
        weighted_sum=weighted_sum,
        dense_product=dense_product,
        sum_parts=sum_parts,
        precondition=precondition,
        constraint_product=constraint_product,
        constraint_force=constraint_force,
        accumulate=accumulate,
        dot_lanes=dot_lanes,
        fold=fold,
        advance=advance,
        turn=turn,
    )
