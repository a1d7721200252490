"""Stable Neo-Hookean (Smith, de Goes and Kim 2018, the final energy of Sect. 3), given by Lame parameters.

    Psi = mu/2 (I_C - 3) - mu/2 ln((I_C + 1) / 4) + lambda/2 ((J - alpha)^2 - (1 - alpha)^2)

with I_C = F:F, J = det F and alpha = 1 + 3 mu / (4 lambda), which makes rest stress-free. The logarithm is the
variant's barrier at the origin: without it F = 0 is a minimum of its own, where a collapsed element would stay;
with it the Hessian vanishes there and the volume term opens the element. There is no barrier in J: inversion
costs a finite energy, lambda/2 (J - 1)^2 and more, and an inverted element is driven back. Their mu and lambda
are not Lame's: mu = 4/3 mu_Lame and lambda = lambda_Lame + 5/6 mu_Lame (their re-parametrisation) give the
linear response asked for.

Departure: constants are dropped so that Psi(I) = 0, and every term is written in G = F - I, where the linear
parts of the three terms cancel exactly instead of in the last digits.

Constants: p[0] = mu_Lame, p[1] = lambda_Lame [Pa].
"""

import warp as wp

from ..precision import Precision
from ..strain import strain_functions
from .triple import MaterialTriple

SERIES_BELOW = 0.02
"""Argument below which x - ln(1 + x) is summed as a series of eight terms: its error is then below 1e-13."""


def neo_hookean(p: Precision) -> MaterialTriple:
    """The triple in one precision."""
    mat33, parameters, scalar = p.mat33, p.parameters, p.scalar
    strain = strain_functions(p.numpy.name)
    displacement_gradient, cofactor, cofactor_product = (
        strain.displacement_gradient, strain.cofactor, strain.cofactor_product,
    )  # fmt: skip
    second_invariant, volume_change = strain.second_invariant, strain.volume_change
    four_thirds, five_sixths = scalar(4.0 / 3.0), scalar(5.0 / 6.0)  # Warp would round them to single precision

    @wp.func
    def shear(p: parameters):
        return four_thirds * p[0]

    @wp.func
    def bulk(p: parameters):
        return p[1] + five_sixths * p[0]

    @wp.func
    def stretch_change(G: mat33):
        """I_C - 3."""
        return scalar(2.0) * wp.trace(G) + wp.ddot(G, G)

    @wp.func
    def less_logarithm(x: scalar):
        """x - ln(1 + x)."""
        result = x - wp.log(scalar(1.0) + x)
        if wp.abs(x) < scalar(SERIES_BELOW):
            series = scalar(0.0)
            for n in range(9, 1, -1):
                series = scalar(1.0) / scalar(n) - x * series
            result = x * x * series
        return result

    @wp.func
    def energy(F: mat33, p: parameters):
        G = displacement_gradient(F)
        volume = volume_change(F)
        quadratic = scalar(0.5) * wp.ddot(G, G) - second_invariant(G) - wp.determinant(G)
        logarithmic = scalar(0.5) * less_logarithm(scalar(0.25) * stretch_change(G))
        isochoric = scalar(0.75) * quadratic + logarithmic
        return shear(p) * isochoric + scalar(0.5) * bulk(p) * volume * volume

    @wp.func
    def gradient(F: mat33, p: parameters):
        G = displacement_gradient(F)
        x = stretch_change(G)
        hardening = scalar(0.25) * x / (x + scalar(4.0))  # 1/4 - 1 / (I_C + 1)
        linear = G + wp.transpose(G) - wp.trace(G) * wp.identity(n=3, dtype=scalar) - cofactor(G)  # F - cof F
        isochoric = hardening * F + scalar(0.75) * linear
        return shear(p) * isochoric + bulk(p) * volume_change(F) * cofactor(F)

    @wp.func
    def hessian(F: mat33, dF: mat33, p: parameters):
        invariant = wp.ddot(F, F) + scalar(1.0)
        slope = scalar(2.0) * wp.ddot(F, dF) / (invariant * invariant)
        isochoric = (scalar(1.0) - scalar(1.0) / invariant) * dF + slope * F
        cof = cofactor(F)
        pressure = bulk(p) * volume_change(F) - scalar(0.75) * shear(p)
        return shear(p) * isochoric + bulk(p) * wp.ddot(cof, dF) * cof + pressure * cofactor_product(F, dF)

    return MaterialTriple(energy, gradient, hessian)
