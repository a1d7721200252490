"""The element's elastic Hessian in the principal frame of F, and its nearest positive-semidefinite one.

For an isotropic law and F = U diag(s) V^T the Hessian of F acts on A = U^T dF V in uncoupled parts (Smith, de
Goes and Kim 2019): a symmetric 3x3 matrix on the diagonal of A, the stretches, and for each pair i < j the
eigenvectors A_ij + A_ji (flip) and A_ij - A_ji (twist). All twelve numbers come from six calls of the law's own
Hessian at diag(s), so that every law, a new one too, is projected by the same lines. Negative eigenvalues become
zero; where there is none the law's Hessian itself is used, so that a definite element is not touched.

Newton's method needs this where a compressed element has softened: it keeps the descent direction, at the price
of linear convergence while any element is projected. Departure from Smith et al.: their eigenvalues are closed
forms of one law each.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from .materials import material_triple
from .precision import precision
from .principal_frame import principal_frame_functions


@cache
def principal_tangent_functions(model: str, precision_name: str) -> SimpleNamespace:
    """Warp functions of one material and precision.

    exact_moduli, definite_moduli(F, material) -> (U, V, stretch, flip, twist, used) of an element's Hessian and
        of its projection: the principal frame, the 3x3 matrix of the stretches and the eigenvalues of the pairs
        (0, 1), (0, 2), (1, 2) [Pa], and whether these are to be used or the law's own Hessian.
    principal_column(U, V, stretch, flip, twist, m, n) -> dP/dF_mn [Pa] of the Hessian that these five describe.
    """
    p = precision(precision_name)
    triple = material_triple(model, precision_name)
    hessian, law_is_principal = triple.hessian, triple.principal
    frame = principal_frame_functions(precision_name)
    principal_frame, symmetric_eigen, diagonal = frame.principal_frame, frame.symmetric_eigen, frame.diagonal
    scalar, vec3, mat33, parameters = p.scalar, p.vec3, p.mat33, p.parameters

    @wp.func
    def principal_moduli(s: vec3, material: parameters):
        """The parts of the Hessian at diag(s)."""
        F = diagonal(s)
        stretch = mat33()
        flip, twist = vec3(), vec3()
        for j in range(3):
            dF = mat33()
            dF[j, j] = scalar(1.0)
            dP = hessian(F, dF, material)
            for i in range(3):
                stretch[i, j] = dP[i, i]
        for pair in range(3):
            i, j = pair // 2, 1 + (pair + 1) // 2
            dF = mat33()
            dF[i, j] = scalar(1.0)
            dP = hessian(F, dF, material)
            flip[pair] = dP[i, j] + dP[j, i]
            twist[pair] = dP[i, j] - dP[j, i]
        return stretch, flip, twist

    @wp.func
    def semidefinite(stretch: mat33, flip: vec3, twist: vec3):
        """The parts without negative eigenvalues, and whether there were any."""
        values, Q = symmetric_eigen(stretch)
        projected = wp.min(wp.min(wp.min(values), wp.min(flip)), wp.min(twist)) < scalar(0.0)
        if projected:
            for i in range(3):
                values[i] = wp.max(values[i], scalar(0.0))
                flip[i] = wp.max(flip[i], scalar(0.0))
                twist[i] = wp.max(twist[i], scalar(0.0))
            stretch = Q * diagonal(values) * wp.transpose(Q)
        return stretch, flip, twist, projected

    @wp.func
    def principal_column(U: mat33, V: mat33, stretch: mat33, flip: vec3, twist: vec3, m: int, n: int):
        u, v = vec3(U[m, 0], U[m, 1], U[m, 2]), vec3(V[n, 0], V[n, 1], V[n, 2])
        A = wp.outer(u, v)  # U^T dF V
        B = diagonal(stretch * vec3(A[0, 0], A[1, 1], A[2, 2]))
        for pair in range(3):
            i, j = pair // 2, 1 + (pair + 1) // 2
            even = scalar(0.5) * flip[pair] * (A[i, j] + A[j, i])
            odd = scalar(0.5) * twist[pair] * (A[i, j] - A[j, i])
            B[i, j] = even + odd
            B[j, i] = even - odd
        return U * B * wp.transpose(V)

    @wp.func
    def exact_moduli(F: mat33, material: parameters):
        U, s, V, _strain = principal_frame(F)
        stretch, flip, twist = principal_moduli(s, material)
        return U, V, stretch, flip, twist, True

    @wp.func
    def definite_moduli(F: mat33, material: parameters):
        U, s, V, _strain = principal_frame(F)
        stretch, flip, twist = principal_moduli(s, material)
        stretch, flip, twist, projected = semidefinite(stretch, flip, twist)
        return U, V, stretch, flip, twist, projected or law_is_principal

    return SimpleNamespace(
        exact_moduli=exact_moduli, definite_moduli=definite_moduli, principal_column=principal_column
    )
