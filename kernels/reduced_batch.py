"""Element stress of many tongues that share one cubature, and what surrounds it in a step.

Arrays have the tongue as their last index, so that neighbouring threads read neighbouring numbers and the
products with H and its transpose are plain matrix products on (rows, 3 * tongue_count). The step is written in
the increment since its start: the increment's gradient is then as accurate as the increment, also in float32,
where the difference of two gradients is not.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from .elasticity import elasticity_functions
from .materials import material_triple
from .precision import precision
from .quasi_newton import STARTING


@cache
def reduced_batch_kernels(model: str, precision_name: str) -> SimpleNamespace:
    """Kernels `stress`, `predict`, `begin`, `meet`, `add` and `advance` of one material and precision."""
    scalar = precision(precision_name).scalar
    # The law works in double precision whatever the arrays hold: a float32 F = I + gradient has lost what the
    # stress of a nearly incompressible tissue is made of, and one element costs the same.
    p = precision("float64")
    mat33, parameters = p.mat33, p.parameters
    triple, functions = material_triple(model, "float64"), elasticity_functions(model, "float64")

    @wp.func
    def block(rows: wp.array(dtype=scalar, ndim=3), e: int, t: int):
        result = mat33()
        for j in range(3):
            for i in range(3):
                result[j, i] = wp.float64(rows[3 * e + j, i, t])
        return result

    @wp.kernel(module="unique")
    def stress(
        gradient_start: wp.array(dtype=scalar, ndim=3),
        increment: wp.array(dtype=scalar, ndim=3),
        weight: wp.array(dtype=wp.float64),
        material: wp.array(dtype=parameters),
        viscosity: wp.array(dtype=parameters),
        damping_over_step: wp.array(dtype=wp.float64),
        stress_out: wp.array(dtype=scalar, ndim=3),
    ):
        """One thread writes the weighted stress of one element of one tongue, elastic and viscous."""
        e, t = wp.tid()
        start, change = block(gradient_start, e, t), block(increment, e, t)
        F0 = functions.deformation_gradient(start)
        F = functions.deformation_gradient(start + change)
        viscous = functions.viscous_product(F0, wp.transpose(change), viscosity[t])
        P = weight[e] * (triple.gradient(F, material[t]) + damping_over_step[t] * viscous)
        for j in range(3):
            for i in range(3):
                stress_out[3 * e + j, i, t] = scalar(P[i, j])

    @wp.kernel(module="unique")
    def predict(
        coordinates: wp.array(dtype=scalar, ndim=2),
        velocity: wp.array(dtype=scalar, ndim=2),
        step: scalar,
        predicted_out: wp.array(dtype=scalar, ndim=2),
        trial_out: wp.array(dtype=scalar, ndim=2),
    ):
        """One thread extrapolates one coordinate with its rate: the first trial, before the sensors."""
        row, t = wp.tid()
        trial_out[row, t] = step * velocity[row, t]
        predicted_out[row, t] = coordinates[row, t] + step * velocity[row, t]

    @wp.kernel(module="unique")
    def begin(
        constrained: wp.array(dtype=scalar, ndim=2),
        target: wp.array(dtype=scalar, ndim=2),
        response: wp.array(dtype=scalar, ndim=2),
        trial_out: wp.array(dtype=scalar, ndim=2),
        direction_out: wp.array(dtype=scalar, ndim=2),
        accepted_out: wp.array(dtype=scalar, ndim=2),
        length_out: wp.array(dtype=scalar),
        state_out: wp.array(dtype=wp.int32),
    ):
        """One thread moves one coordinate of the first trial so that the sensors meet their targets."""
        row, t = wp.tid()
        change = trial_out[row, t]
        for c in range(target.shape[0]):
            change += response[row, c] * (target[c, t] - constrained[c, t])
        trial_out[row, t] = change
        direction_out[row, t] = change
        accepted_out[row, t] = scalar(0.0)
        if row == 0:
            length_out[t] = scalar(1.0)
            state_out[t] = STARTING

    @wp.kernel(module="unique")
    def meet(
        constrained: wp.array(dtype=scalar, ndim=2),
        target: wp.array(dtype=scalar, ndim=2),
        response: wp.array(dtype=scalar, ndim=2),
        accepted_out: wp.array(dtype=scalar, ndim=2),
    ):
        """One thread moves one coordinate by what rounding along the iterations has taken the sensors off."""
        row, t = wp.tid()
        change = accepted_out[row, t]
        for c in range(target.shape[0]):
            change += response[row, c] * (target[c, t] - constrained[c, t])
        accepted_out[row, t] = change

    @wp.kernel(module="unique")
    def add(
        coordinates: wp.array(dtype=scalar, ndim=3),
        increment: wp.array(dtype=scalar, ndim=3),
        sum_out: wp.array(dtype=scalar, ndim=3),
    ):
        """One thread adds one coordinate's increment to where the step began."""
        k, i, t = wp.tid()
        sum_out[k, i, t] = coordinates[k, i, t] + increment[k, i, t]

    @wp.kernel(module="unique")
    def advance(
        increment: wp.array(dtype=scalar, ndim=2),
        step: scalar,
        coordinates_out: wp.array(dtype=scalar, ndim=2),
        velocity_out: wp.array(dtype=scalar, ndim=2),
    ):
        """One thread adds one coordinate's increment [sqrt(kg) m] and sets its rate."""
        row, t = wp.tid()
        coordinates_out[row, t] = coordinates_out[row, t] + increment[row, t]
        velocity_out[row, t] = increment[row, t] / step

    return SimpleNamespace(stress=stress, predict=predict, begin=begin, meet=meet, add=add, advance=advance)
