"""Five-parameter Mooney-Rivlin with a bulk modulus, the law of the biomechanical tongues of Gerard and Buchaillard.

    Psi = C10 i + C01 j + C11 i j + C20 i^2 + C02 j^2 + kappa/2 (J - 1)^2,
    i = J^(-2/3) I1 - 3,   j = J^(-4/3) I2 - 3,

with I1 = tr C, I2 = (tr(C)^2 - tr(C^2)) / 2, C = F^T F and J = det F: i and j measure the change of shape alone.
In small strain mu = 2 (C10 + C01). Sources: Gerard et al. 2005 (the law, with C10 and C20 only), Buchaillard et
al. 2009 (its constants for living tissue); the quadratic bulk term is that of the ArtiSynth tongue.

Departure: J^(-2/3) does not exist for a collapsed or inverted element. Below J = `REGULAR_VOLUME` it is taken at

    J~ = J0 (1 + 1 / (1 - y + y^2)) / 2,   y = 2 (J / J0 - 1),   J0 = REGULAR_VOLUME,

which continues J with two continuous derivatives and falls to J0 / 2. Energy and stress stay finite for every F,
and the bulk term, which is not altered, drives an inverted element back.

Constants: p = (C10, C01, C11, C20, C02, kappa) [Pa].
"""

import warp as wp

from ..precision import Precision
from ..strain import strain_functions
from .triple import MaterialTriple

REGULAR_VOLUME = 0.2
"""det F below which shape is measured with a continued volume; tongues in speech stay above 0.3."""


def mooney_rivlin(p: Precision) -> MaterialTriple:
    """The triple in one precision."""
    mat33, parameters, scalar = p.mat33, p.parameters, p.scalar
    strain = strain_functions(p.numpy.name)
    displacement_gradient, green_strain = strain.displacement_gradient, strain.green_strain
    cofactor, cofactor_product = strain.cofactor, strain.cofactor_product
    second_invariant, volume_change = strain.second_invariant, strain.volume_change
    # Warp would work such expressions out in single precision.
    two_thirds, four_thirds = scalar(2.0 / 3.0), scalar(4.0 / 3.0)
    half_volume, least_change = scalar(0.5 * REGULAR_VOLUME), scalar(REGULAR_VOLUME - 1.0)

    @wp.func
    def regular_volume(change: scalar):
        """J~ - 1, and dJ~/dJ and d2J~/dJ2 over J~, of J - 1."""
        value, first, second = change, scalar(1.0), scalar(0.0)
        if change < least_change:
            y = (change - least_change) / half_volume
            q = scalar(1.0) / (scalar(1.0) - y + y * y)
            slope = scalar(1.0) - scalar(2.0) * y
            value = half_volume * (scalar(1.0) + q) - scalar(1.0)
            first = slope * q * q
            second = scalar(2.0) * q * q * (slope * slope * q - scalar(1.0)) / half_volume
        volume = scalar(1.0) + value
        return value, first / volume, second / volume

    @wp.func
    def shape_change(x: scalar, x2: scalar, change: scalar):
        """(i, j, J~^(-2/3)) of I1 - 3, I2 - 3 and J~ - 1."""
        t = wp.cbrt(scalar(1.0) + change)
        t_change = change / (t * t + t + scalar(1.0))
        a = scalar(1.0) / (t * t)
        i = a * (x - scalar(3.0) * t_change * (t + scalar(1.0)))
        j = a * a * (x2 - scalar(3.0) * t_change * (t + scalar(1.0)) * (t * t + scalar(1.0)))
        return i, j, a

    @wp.func
    def first_changes(F: mat33):
        """I1 - 3 and I2 - 3."""
        E = green_strain(F)
        x = scalar(2.0) * wp.trace(E)
        return x, scalar(2.0) * x + scalar(4.0) * second_invariant(E)

    @wp.func
    def slopes(i: scalar, j: scalar, p: parameters):
        """dPsi/di and dPsi/dj."""
        return p[0] + p[2] * j + scalar(2.0) * p[3] * i, p[1] + p[2] * i + scalar(2.0) * p[4] * j

    @wp.func
    def shape_gradients(F: mat33, x: scalar, x2: scalar, change: scalar, a: scalar, rate: scalar):
        """di/dF and dj/dF; change = J~ - 1, rate = (dJ~/dJ) / J~."""
        identity = wp.identity(n=3, dtype=scalar)
        G = displacement_gradient(F)
        cof = cofactor(F)
        linear = G + wp.transpose(G) - wp.trace(G) * identity - cofactor(G)  # F - cof F
        # 1 - (1 + x/3) rate, which is small at small strain; rate = 1/J where the volume is regular.
        first = scalar(1.0) - (scalar(1.0) + x / scalar(3.0)) * rate
        second = scalar(1.0) - (scalar(1.0) + x2 / scalar(3.0)) * rate
        if change >= least_change:
            first = (change - x / scalar(3.0)) * rate
            second = (change - x2 / scalar(3.0)) * rate
        shear = F * (x * identity - scalar(2.0) * green_strain(F))
        gradient_i = scalar(2.0) * a * (linear + first * cof)
        gradient_j = scalar(2.0) * a * a * (scalar(2.0) * linear + shear + scalar(2.0) * second * cof)
        return gradient_i, gradient_j

    @wp.func
    def energy(F: mat33, p: parameters):
        volume = volume_change(F)
        x, x2 = first_changes(F)
        change, _rate, _curvature = regular_volume(volume)
        i, j, _a = shape_change(x, x2, change)
        shape = p[0] * i + p[1] * j + p[2] * i * j + p[3] * i * i + p[4] * j * j
        return shape + scalar(0.5) * p[5] * volume * volume

    @wp.func
    def gradient(F: mat33, p: parameters):
        volume = volume_change(F)
        x, x2 = first_changes(F)
        change, rate, _ = regular_volume(volume)
        i, j, a = shape_change(x, x2, change)
        gradient_i, gradient_j = shape_gradients(F, x, x2, change, a, rate)
        slope_i, slope_j = slopes(i, j, p)
        return slope_i * gradient_i + slope_j * gradient_j + p[5] * volume * cofactor(F)

    @wp.func
    def invariant_product(
        g: mat33, dg: mat33, invariant: scalar, power: scalar, factor: scalar, F: mat33, dF: mat33,
        rate: scalar, curvature: scalar,
    ):  # fmt: skip
        """Change along dF of d(J~^-power I)/dF, for I with gradient g and change dg of it; factor = J~^-power."""
        cof = cofactor(F)
        q = wp.ddot(cof, dF)
        first = -power * rate
        second = power * (power + scalar(1.0)) * rate * rate - power * curvature
        change = dg + first * (q * g + wp.ddot(g, dF) * cof + invariant * cofactor_product(F, dF))
        return factor * (change + second * invariant * q * cof)

    @wp.func
    def hessian(F: mat33, dF: mat33, p: parameters):
        volume = volume_change(F)
        x, x2 = first_changes(F)
        change, rate, curvature = regular_volume(volume)
        i, j, a = shape_change(x, x2, change)
        gradient_i, gradient_j = shape_gradients(F, x, x2, change, a, rate)
        slope_i, slope_j = slopes(i, j, p)

        C = wp.transpose(F) * F
        dC = wp.transpose(dF) * F + wp.transpose(F) * dF
        first, second = scalar(3.0) + x, scalar(3.0) + x2
        g2 = scalar(2.0) * (first * F - F * C)
        dg2 = scalar(2.0) * (wp.trace(dC) * F + first * dF - dF * C - F * dC)
        g1, dg1 = scalar(2.0) * F, scalar(2.0) * dF
        product_i = invariant_product(g1, dg1, first, two_thirds, a, F, dF, rate, curvature)
        product_j = invariant_product(g2, dg2, second, four_thirds, a * a, F, dF, rate, curvature)

        di, dj = wp.ddot(gradient_i, dF), wp.ddot(gradient_j, dF)
        change_i = scalar(2.0) * p[3] * di + p[2] * dj
        change_j = p[2] * di + scalar(2.0) * p[4] * dj
        cof = cofactor(F)
        bulk = p[5] * (wp.ddot(cof, dF) * cof + volume * cofactor_product(F, dF))
        shape = slope_i * product_i + slope_j * product_j + change_i * gradient_i + change_j * gradient_j
        return shape + bulk

    return MaterialTriple(energy, gradient, hessian)
