"""The projected inverse of a reduced Hessian brought up to date on its device, one iteration a step.

Newton-Schulz: Z <- P (Z + a (Z - Z A Z)), with A the Hessian and P the projector onto the null space of the
constraints. With a = 1 the error is squared as long as Z is near, so that one iteration a step follows a tangent
that changes slowly, without a factorisation. It diverges once an eigenvalue of A Z exceeds 2, so a is smaller
where power iteration finds a large one. P removes what rounding leaks into the constraints' rows, which the
iteration would double every time.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from .elasticity import elasticity_functions
from .materials import material_triple
from .precision import precision

SAFE = 0.5
"""Share of the way to the edge of convergence that a step may go."""


@cache
def inverse_update_kernels(model: str, precision_name: str) -> SimpleNamespace:
    """Kernels `mean`, `tangent`, `assemble`, `normalise` and `update` of one material and precision."""
    scalar, storage = precision(precision_name).scalar, precision(precision_name).mat33
    p = precision("float64")
    mat33, parameters = p.mat33, p.parameters
    triple, functions = material_triple(model, "float64"), elasticity_functions(model, "float64")

    @wp.kernel(module="unique")
    def mean(coordinates: wp.array(dtype=scalar, ndim=3), mean_out: wp.array(dtype=scalar, ndim=2)):
        """One block writes the mean of one coordinate over the tongues."""
        k, i, lane = wp.tid()
        partial = scalar(0.0)
        for t in range(lane, coordinates.shape[2], wp.block_dim()):
            partial += coordinates[k, i, t]
        total = wp.tile_extract(wp.tile_sum(wp.tile(partial)), 0)
        if lane == 0:
            mean_out[k, i] = total / scalar(coordinates.shape[2])

    @wp.kernel(module="unique")
    def tangent(
        gradient: wp.array(dtype=scalar, ndim=2),
        weight: wp.array(dtype=wp.float64),
        material: parameters,
        viscosity: parameters,
        damping_over_step: wp.float64,
        tangent_out: wp.array(dtype=storage, ndim=3),
    ):
        """One thread writes one of nine columns of one element's weighted tangent at the start of a step.

        tangent_out[e, i, m][j, n] = dP_ij / dF_mn.
        """
        e, column = wp.tid()
        start = mat33()
        for j in range(3):
            for i in range(3):
                start[j, i] = wp.float64(gradient[3 * e + j, i])
        F = functions.deformation_gradient(start)
        m, n = column // 3, column % 3
        dF = mat33()
        dF[m, n] = wp.float64(1.0)
        viscous = functions.viscous_product(F, dF, viscosity)
        dP = weight[e] * (triple.hessian(F, dF, material) + damping_over_step * viscous)
        for i in range(3):
            for j in range(3):
                tangent_out[e, i, m][j, n] = scalar(dP[i, j])

    @wp.kernel(module="unique")
    def assemble(
        blocks: wp.array(dtype=scalar, ndim=3),
        shift: scalar,
        matrix_out: wp.array(dtype=scalar, ndim=2),
    ):
        """One thread writes the 3x3 block (k, l) of the Hessian from the six blocks of components and the inertia."""
        k, l = wp.tid()
        pair = int(0)
        for i in range(3):
            for m in range(i, 3):
                value = blocks[k, pair, l]
                if i == m:
                    if k == l:
                        value += shift
                    matrix_out[3 * k + i, 3 * l + i] = value
                else:
                    matrix_out[3 * k + i, 3 * l + m] = value
                    matrix_out[3 * l + m, 3 * k + i] = value
                pair += 1

    @wp.kernel(module="unique")
    def normalise(
        image: wp.array(dtype=scalar, ndim=2),
        vector_out: wp.array(dtype=scalar, ndim=2),
        growth_out: wp.array(dtype=scalar),
    ):
        """One block ends a power iteration: the vector's image at unit length, and how much it had grown.

        growth: negative where the image points backwards.
        """
        lane = wp.tid()
        partial, along = scalar(0.0), scalar(0.0)
        for row in range(lane, image.shape[0], wp.block_dim()):
            partial += image[row, 0] * image[row, 0]
            along += image[row, 0] * vector_out[row, 0]
        length = wp.sqrt(wp.tile_extract(wp.tile_sum(wp.tile(partial)), 0)) + scalar(1.0e-30)
        same_way = wp.tile_extract(wp.tile_sum(wp.tile(along)), 0)
        for row in range(lane, image.shape[0], wp.block_dim()):
            value = image[row, 0] / length
            if not wp.isfinite(value):  # begin again with a vector that has a part along every other one
                value = wp.sin(scalar(row + 1))
            vector_out[row, 0] = value
        if lane == 0:
            growth_out[0] = length * wp.sign(same_way)

    @wp.kernel(module="unique")
    def update(
        inverse: wp.array(dtype=scalar, ndim=2),
        product: wp.array(dtype=scalar, ndim=2),
        growth: wp.array(dtype=scalar),
        safe: wp.array(dtype=scalar, ndim=2),
        candidate_out: wp.array(dtype=scalar, ndim=2),
    ):
        """One thread writes one number of Z + a (Z - Z A Z), or of `safe` where Z is beyond repair."""
        row, column = wp.tid()
        share = wp.min(scalar(1.0), scalar(SAFE) / wp.max(growth[0] - scalar(1.0), scalar(SAFE)))
        value = inverse[row, column]
        value += share * (value - product[row, column])
        if not growth[0] > scalar(0.0):  # a negative eigenvalue, or not a number
            value = safe[row, column]
        candidate_out[row, column] = value

    return SimpleNamespace(mean=mean, tangent=tangent, assemble=assemble, normalise=normalise, update=update)
