"""St. Venant-Kirchhoff: Psi = mu E:E + lambda/2 tr(E)^2, P = F (2 mu E + lambda tr(E) I).

E = (F^T F - I) / 2 is the Green strain. Source: Luo 2017, section 6. The stress is cubic in F and vanishes
again at collapse: below a uniaxial stretch of 1 / sqrt(3) = 0.58 the law softens, and an element that is
pressed further turns inside out, where its energy is that of its mirror image.

Constants: p[0] = mu, p[1] = lambda [Pa].
"""

import warp as wp

from ..precision import Precision
from ..strain import strain_functions
from .triple import MaterialTriple


def stvk(p: Precision) -> MaterialTriple:
    """The triple in one precision."""
    mat33, parameters, scalar = p.mat33, p.parameters, p.scalar
    green_strain = strain_functions(p.numpy.name).green_strain

    @wp.func
    def linear_stress(E: mat33, p: parameters):
        return scalar(2.0) * p[0] * E + p[1] * wp.trace(E) * wp.identity(n=3, dtype=scalar)

    @wp.func
    def energy(F: mat33, p: parameters):
        E = green_strain(F)
        return p[0] * wp.ddot(E, E) + scalar(0.5) * p[1] * wp.trace(E) * wp.trace(E)

    @wp.func
    def gradient(F: mat33, p: parameters):
        return F * linear_stress(green_strain(F), p)

    @wp.func
    def hessian(F: mat33, dF: mat33, p: parameters):
        dE = scalar(0.5) * (wp.transpose(dF) * F + wp.transpose(F) * dF)
        return dF * linear_stress(green_strain(F), p) + F * linear_stress(dE, p)

    return MaterialTriple(energy, gradient, hessian)
