"""Corotational: linear elasticity in the frame of the polar rotation.

    Psi = mu |S - I|^2 + lambda/2 tr(S - I)^2,   P = R (2 mu (S - I) + lambda tr(S - I) I),   F = R S

R is the rotation nearest to F (never a reflection: an inverted element has a negative smallest stretch, and is
pulled back through its thinnest direction). With F = U diag(s) V^T, A = U^T dF V and dR the change of R, the
Hessian is exact,

    dP = 2 mu dF + lambda tr(R^T dF) R + (lambda tr(S - I) - 2 mu) dR,
    (U^T dR V)_ij = (A_ij - A_ji) / (s_i + s_j),

and not the warped linear stiffness, which leaves dR out. Source: Smith, de Goes and Kim 2019 (analytic
eigensystems, the "ARAP" rotation gradient); Müller and Gross 2004 for the law.

The energy has a kink where s_i + s_j = 0, an element inverted through two equal stretches: there R jumps and
the Hessian grows without bound. `LEAST_STRETCH_SUM` bounds it.

Constants: p[0] = mu, p[1] = lambda [Pa].
"""

import warp as wp

from ..precision import Precision
from ..principal_frame import principal_frame_functions
from .triple import MaterialTriple

LEAST_STRETCH_SUM = 1e-3
"""Divisor of the rotation's change from below; the sum of two principal stretches is 2 at rest."""


def corotational(p: Precision) -> MaterialTriple:
    """The triple in one precision."""
    vec3, mat33, parameters, scalar = p.vec3, p.mat33, p.parameters, p.scalar
    frame = principal_frame_functions(p.numpy.name)
    principal_frame, diagonal = frame.principal_frame, frame.diagonal

    @wp.func
    def total(a: vec3):
        return a[0] + a[1] + a[2]

    @wp.func
    def energy(F: mat33, p: parameters):
        _U, _s, _V, strain = principal_frame(F)
        return p[0] * wp.dot(strain, strain) + scalar(0.5) * p[1] * total(strain) * total(strain)

    @wp.func
    def gradient(F: mat33, p: parameters):
        U, _s, V, strain = principal_frame(F)
        spherical = p[1] * total(strain)
        stress = scalar(2.0) * p[0] * strain + vec3(spherical, spherical, spherical)
        return U * diagonal(stress) * wp.transpose(V)

    @wp.func
    def hessian(F: mat33, dF: mat33, p: parameters):
        U, s, V, strain = principal_frame(F)
        A = wp.transpose(U) * dF * V
        turning = p[1] * total(strain) - scalar(2.0) * p[0]
        B = scalar(2.0) * p[0] * A + p[1] * wp.trace(A) * wp.identity(n=3, dtype=scalar)
        for i in range(3):
            for j in range(3):
                if i != j:
                    B[i, j] += turning * (A[i, j] - A[j, i]) / wp.max(s[i] + s[j], scalar(LEAST_STRETCH_SUM))
        return U * B * wp.transpose(V)

    return MaterialTriple(energy, gradient, hessian, principal=True)
