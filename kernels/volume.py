"""Volumes of elements and of the whole tongue, and their rates, for one shape or a batch of reduced tongues.

Batched arrays end in the tongue index t. Element e's displacement gradient G has row 3 e + j and component i:
du_i/dX_j, F = I + G^T. Its excess is det F - 1 = tr G + (sum of principal 2 x 2 minors) + det G, summed in that
form because 1 + small - 1 would lose the digits that matter in float32; its rate is cof(F) : dF/dt.

The whole volume is a polynomial (model/volume_polynomial.py): with the coordinates q_a, continued by the three unit
vectors, and M = coefficients x (cross products q_b x q_c), the volume's gradient with respect to q_a is row a of M.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from .precision import precision


@cache
def volume_kernels(precision_name: str) -> SimpleNamespace:
    """Kernels of one precision; see their docstrings."""
    p = precision(precision_name)
    scalar, vec3, mat33 = p.scalar, p.vec3, p.mat33

    @wp.func
    def element_matrix(stacked: wp.array(dtype=scalar, ndim=3), e: int, t: int):
        G = mat33()
        for j in range(3):
            for i in range(3):
                G[j, i] = stacked[3 * e + j, i, t]
        return G

    @wp.func
    def row_vector(rows: wp.array(dtype=scalar, ndim=3), a: int, t: int):
        return vec3(rows[a, 0, t], rows[a, 1, t], rows[a, 2, t])

    @wp.func
    def continued(rows: wp.array(dtype=scalar, ndim=3), a: int, t: int):
        count = rows.shape[0]
        v = vec3()
        if a < count:
            v = row_vector(rows, a, t)
        else:
            v[a - count] = scalar(1.0)
        return v

    @wp.kernel(module="unique")
    def element_volumes(
        position: wp.array(dtype=vec3),
        tets: wp.array(dtype=wp.int32, ndim=2),
        volume_out: wp.array(dtype=scalar),
        volume_gradient_out: wp.array(dtype=vec3, ndim=2),
    ):
        """One thread writes one element's signed volume and its gradient with respect to its four nodes."""
        e = wp.tid()
        x0 = position[tets[e, 0]]
        a = position[tets[e, 1]] - x0
        b = position[tets[e, 2]] - x0
        c = position[tets[e, 3]] - x0
        sixth = scalar(1.0) / scalar(6.0)
        g1 = sixth * wp.cross(b, c)
        g2 = sixth * wp.cross(c, a)
        g3 = sixth * wp.cross(a, b)
        volume_out[e] = wp.dot(g1, a)
        volume_gradient_out[e, 0] = -(g1 + g2 + g3)
        volume_gradient_out[e, 1] = g1
        volume_gradient_out[e, 2] = g2
        volume_gradient_out[e, 3] = g3

    @wp.kernel(module="unique")
    def volume_excess(
        gradient: wp.array(dtype=scalar, ndim=3), excess_out: wp.array(dtype=scalar, ndim=2)
    ):
        """One thread writes det F - 1 of one element of one tongue."""
        e, t = wp.tid()
        G = element_matrix(gradient, e, t)
        minors = (
            G[0, 0] * G[1, 1]
            - G[0, 1] * G[1, 0]
            + G[1, 1] * G[2, 2]
            - G[1, 2] * G[2, 1]
            + G[0, 0] * G[2, 2]
            - G[0, 2] * G[2, 0]
        )
        excess_out[e, t] = wp.trace(G) + minors + wp.determinant(G)

    @wp.kernel(module="unique")
    def volume_rate(
        gradient: wp.array(dtype=scalar, ndim=3),
        gradient_rate: wp.array(dtype=scalar, ndim=3),
        rate_out: wp.array(dtype=scalar, ndim=2),
    ):
        """One thread writes the rate of det F of one element of one tongue."""
        e, t = wp.tid()
        F = element_matrix(gradient, e, t)  # transposed, which changes neither the determinant nor the rate
        for i in range(3):
            F[i, i] = F[i, i] + scalar(1.0)
        rate = element_matrix(gradient_rate, e, t)
        result = wp.dot(wp.cross(F[1], F[2]), rate[0])
        result += wp.dot(wp.cross(F[2], F[0]), rate[1])
        result += wp.dot(wp.cross(F[0], F[1]), rate[2])
        rate_out[e, t] = result

    @wp.kernel(module="unique")
    def cross_products(
        coordinates: wp.array(dtype=scalar, ndim=3),
        pairs: wp.array(dtype=wp.int32, ndim=2),
        product_out: wp.array(dtype=scalar, ndim=3),
    ):
        """One thread writes q_b x q_c of one pair of one tongue; rows past the last are the unit vectors."""
        pair, t = wp.tid()
        product = wp.cross(continued(coordinates, pairs[pair, 0], t), continued(coordinates, pairs[pair, 1], t))
        for i in range(3):
            product_out[pair, i, t] = product[i]

    @wp.kernel(module="unique")
    def volume_step(
        values: wp.array(dtype=scalar, ndim=3),
        volume_gradient: wp.array(dtype=scalar, ndim=3),
        direction: wp.array(dtype=scalar, ndim=3),
        scale: scalar,
        row_count: int,
        lanes: int,
        change_out: wp.array(dtype=scalar),
        step_out: wp.array(dtype=scalar),
    ):
        """One block sums scale * values . gradient over `row_count` rows of one tongue, and its ratio to the slope.

        The slope is direction . gradient; values past their last row are the unit vectors.
        """
        t, lane = wp.tid()
        change = scalar(0.0)
        slope = scalar(0.0)
        for a in range(lane, row_count, lanes):
            g = row_vector(volume_gradient, a, t)
            change += wp.dot(continued(values, a, t), g)
            if a < direction.shape[0]:
                slope += wp.dot(row_vector(direction, a, t), g)
        change_sum = wp.tile_sum(wp.tile(scale * change))
        slope_sum = wp.tile_sum(wp.tile(slope))
        total = wp.tile_extract(change_sum, 0)
        total_slope = wp.tile_extract(slope_sum, 0)
        if lane == 0:
            change_out[t] = total
            step_out[t] = scalar(0.0)
            if total_slope > scalar(0.0):
                step_out[t] = total / total_slope

    @wp.kernel(module="unique")
    def retreat(
        step: wp.array(dtype=scalar),
        direction: wp.array(dtype=scalar, ndim=3),
        values_out: wp.array(dtype=scalar, ndim=3),
    ):
        """One thread subtracts its tongue's step along the direction from one value."""
        a, i, t = wp.tid()
        values_out[a, i, t] = values_out[a, i, t] - step[t] * direction[a, i, t]

    @wp.kernel(module="unique")
    def add(change: wp.array(dtype=scalar, ndim=3), values_out: wp.array(dtype=scalar, ndim=3)):
        """One thread adds one change to one value."""
        a, i, t = wp.tid()
        values_out[a, i, t] = values_out[a, i, t] + change[a, i, t]

    return SimpleNamespace(
        element_volumes=element_volumes,
        volume_excess=volume_excess,
        volume_rate=volume_rate,
        cross_products=cross_products,
        volume_step=volume_step,
        retreat=retreat,
        add=add,
    )
