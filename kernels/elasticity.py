"""Per-element strain energy, stress and tangent of an implicit step, for any material triple.

For an element with displacement gradient now (`gradient`) and at the start of the step
(`gradient_start`), F = I + gradient^T and F0 = I + gradient_start^T, the incremental potential is

    W(F) = Psi(F) + h (mu_v D:D + lambda_v/2 tr(D)^2),   D = sym(F0^T (F - F0)) / h,

whose second part is the Kelvin-Voigt form of stiffness-proportional Rayleigh damping with
(mu_v, lambda_v) = damping_stiffness * (mu, lambda). At rest its Hessian is exactly damping_stiffness
times the elastic stiffness over h (Luo 2017, section 8, uses that). Away from rest it differs from
damping by the current tangent: it never feeds energy in under compression, and a rigid rotation rate
costs nothing. `damping_over_step` below is damping_stiffness / h; zero switches it off.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from .materials import material_triple
from .precision import precision


@cache
def elasticity_kernels(model: str, precision_name: str) -> SimpleNamespace:
    """Kernels `energy`, `stress`, `tangent` and `tangent_product` of one material and precision."""
    p = precision(precision_name)
    triple = material_triple(model, precision_name)
    scalar, mat33, parameters = p.scalar, p.mat33, p.parameters

    @wp.func
    def deformation_gradient(gradient: mat33):
        return wp.identity(n=3, dtype=scalar) + wp.transpose(gradient)

    @wp.func
    def viscous_product(F0: mat33, dF: mat33, q: parameters):
        rate = scalar(0.5) * (wp.transpose(dF) * F0 + wp.transpose(F0) * dF)
        return F0 * (scalar(2.0) * q[0] * rate + q[1] * wp.trace(rate) * wp.identity(n=3, dtype=scalar))

    @wp.kernel(module="unique")
    def energy(
        gradient: wp.array(dtype=mat33),
        material: parameters,
        density_out: wp.array(dtype=scalar),
        det_f_out: wp.array(dtype=scalar),
    ):
        """One thread writes one element's strain energy density [Pa] and det F."""
        e = wp.tid()
        F = deformation_gradient(gradient[e])
        density_out[e] = triple.energy(F, material)
        det_f_out[e] = wp.determinant(F)

    @wp.kernel(module="unique")
    def stress(
        gradient: wp.array(dtype=mat33),
        gradient_start: wp.array(dtype=mat33),
        weight: wp.array(dtype=scalar),
        material: parameters,
        viscosity: parameters,
        damping_over_step: scalar,
        stress_out: wp.array(dtype=mat33),
    ):
        """One thread writes one element's weighted first Piola stress, elastic and viscous, transposed."""
        e = wp.tid()
        F = deformation_gradient(gradient[e])
        F0 = deformation_gradient(gradient_start[e])
        P = triple.gradient(F, material) + damping_over_step * viscous_product(F0, F - F0, viscosity)
        stress_out[e] = weight[e] * wp.transpose(P)

    @wp.kernel(module="unique")
    def tangent(
        gradient: wp.array(dtype=mat33),
        gradient_start: wp.array(dtype=mat33),
        weight: wp.array(dtype=scalar),
        material: parameters,
        viscosity: parameters,
        damping_over_step: scalar,
        tangent_out: wp.array(dtype=mat33, ndim=3),
    ):
        """One thread writes one element's weighted tangent: tangent_out[e, i, m][j, n] = dP_ij / dF_mn."""
        e = wp.tid()
        F = deformation_gradient(gradient[e])
        F0 = deformation_gradient(gradient_start[e])
        for m in range(3):
            for n in range(3):
                dF = mat33()
                dF[m, n] = scalar(1.0)
                dP = triple.hessian(F, dF, material) + damping_over_step * viscous_product(F0, dF, viscosity)
                for i in range(3):
                    for j in range(3):
                        tangent_out[e, i, m][j, n] = weight[e] * dP[i, j]

    @wp.kernel(module="unique")
    def tangent_product(
        tangent: wp.array(dtype=mat33, ndim=3),
        direction: wp.array(dtype=mat33),
        product_out: wp.array(dtype=mat33),
    ):
        """One thread applies one element's tangent to a displacement gradient, both transposed like stress."""
        e = wp.tid()
        product = mat33()
        for i in range(3):
            column = tangent[e, i, 0] * wp.transpose(direction[e])[0]
            column += tangent[e, i, 1] * wp.transpose(direction[e])[1]
            column += tangent[e, i, 2] * wp.transpose(direction[e])[2]
            for j in range(3):
                product[j, i] = column[j]
        product_out[e] = product

    return SimpleNamespace(energy=energy, stress=stress, tangent=tangent, tangent_product=tangent_product)
