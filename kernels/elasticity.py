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
from .principal_tangent import principal_tangent_functions


@cache
def elasticity_functions(model: str, precision_name: str) -> SimpleNamespace:
    """Warp functions of one element, for kernels that need more than one quantity at a time.

    deformation_gradient(gradient) -> F = I + gradient^T.
    energy_density(F, material) -> Psi [Pa].
    incremental_energy(F, F0, material, viscosity, damping_over_step) -> W [Pa].
    first_piola(F, F0, material, viscosity, damping_over_step) -> dW/dF [Pa].
    viscous_product(F0, dF, viscosity) -> the viscous Hessian applied to dF, for damping_over_step = 1 [Pa].
    """
    p = precision(precision_name)
    triple = material_triple(model, precision_name)
    scalar, mat33, parameters = p.scalar, p.mat33, p.parameters

    @wp.func
    def deformation_gradient(gradient: mat33):
        return wp.identity(n=3, dtype=scalar) + wp.transpose(gradient)

    @wp.func
    def viscous_product(F0: mat33, dF: mat33, viscosity: parameters):
        rate = scalar(0.5) * (wp.transpose(dF) * F0 + wp.transpose(F0) * dF)
        spherical = viscosity[1] * wp.trace(rate) * wp.identity(n=3, dtype=scalar)
        return F0 * (scalar(2.0) * viscosity[0] * rate + spherical)

    @wp.func
    def energy_density(F: mat33, material: parameters):
        return triple.energy(F, material)

    @wp.func
    def incremental_energy(
        F: mat33, F0: mat33, material: parameters, viscosity: parameters, damping_over_step: scalar
    ):
        change = F - F0
        viscous = scalar(0.5) * damping_over_step * wp.ddot(change, viscous_product(F0, change, viscosity))
        return triple.energy(F, material) + viscous

    @wp.func
    def first_piola(F: mat33, F0: mat33, material: parameters, viscosity: parameters, damping_over_step: scalar):
        return triple.gradient(F, material) + damping_over_step * viscous_product(F0, F - F0, viscosity)

    return SimpleNamespace(
        deformation_gradient=deformation_gradient,
        viscous_product=viscous_product,
        energy_density=energy_density,
        incremental_energy=incremental_energy,
        first_piola=first_piola,
    )


@cache
def elasticity_kernels(model: str, precision_name: str) -> SimpleNamespace:
    """Kernels of one material and precision: `energy`, `stress`, `tangent`, `definite_tangent`, `tangent_product`.

    `definite_tangent` is `tangent` with every element's elastic part projected onto the semidefinite ones; the
    viscous part is semidefinite as it is.
    """
    p = precision(precision_name)
    triple = material_triple(model, precision_name)
    principal = principal_tangent_functions(model, precision_name)
    functions = elasticity_functions(model, precision_name)
    scalar, mat33, parameters = p.scalar, p.mat33, p.parameters
    deformation_gradient, first_piola = functions.deformation_gradient, functions.first_piola
    energy_density, viscous_product = functions.energy_density, functions.viscous_product

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
        density_out[e] = energy_density(F, material)
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
        P = first_piola(F, F0, material, viscosity, damping_over_step)
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

    def tangent_in_the_principal_frame(moduli: wp.Function) -> wp.Kernel:
        @wp.kernel(module="unique")
        def principal_tangent(
            gradient: wp.array(dtype=mat33),
            gradient_start: wp.array(dtype=mat33),
            weight: wp.array(dtype=scalar),
            material: parameters,
            viscosity: parameters,
            damping_over_step: scalar,
            tangent_out: wp.array(dtype=mat33, ndim=3),
        ):
            """One thread writes one element's weighted tangent by way of its principal moduli."""
            e = wp.tid()
            F = deformation_gradient(gradient[e])
            F0 = deformation_gradient(gradient_start[e])
            U, V, stretch, flip, twist, used = moduli(F, material)
            column = int(0)
            while column < 9:  # not unrolled: nine copies of the law's Hessian run slower than one
                m, n = column // 3, column % 3
                dF = mat33()
                dF[m, n] = scalar(1.0)
                dP = damping_over_step * viscous_product(F0, dF, viscosity)
                if used:
                    dP += principal.principal_column(U, V, stretch, flip, twist, m, n)
                else:
                    dP += triple.hessian(F, dF, material)
                for i in range(3):
                    for j in range(3):
                        tangent_out[e, i, m][j, n] = weight[e] * dP[i, j]
                column += 1

        return principal_tangent

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

    return SimpleNamespace(
        energy=energy,
        stress=stress,
        tangent=tangent_in_the_principal_frame(principal.exact_moduli) if triple.principal else tangent,
        definite_tangent=tangent_in_the_principal_frame(principal.definite_moduli),
        tangent_product=tangent_product,
    )
