"""Warp functions for the principal frame of a deformation: symmetric eigenvectors and signed singular values.

F = U diag(s) V^T with rotations U and V, so a reflection shows as a negative s[2]: s[0] >= s[1] >= |s[2]|.
V are the eigenvectors of the Green strain, by Jacobi's cyclic rotations (Golub and Van Loan, Matrix
Computations, section 8.5); the columns of U are those of F V, made orthonormal one after the other. Unlike a
decomposition of F itself, this gives exactly U = V = I at rest and keeps small strains in single precision.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from .precision import precision
from .strain import strain_functions

MAXIMUM_SWEEPS = 12
"""Jacobi converges quadratically; five sweeps are usual in double precision."""
NEGLIGIBLE = {"float32": 1e-14, "float64": 1e-31}
"""Square of the off-diagonal part, relative to the square of the diagonal, at which a matrix is diagonal."""


@cache
def principal_frame_functions(precision_name: str) -> SimpleNamespace:
    """Warp functions of one precision.

    symmetric_eigen(A) -> (eigenvalues, in no order, eigenvectors as columns of a rotation).
    principal_frame(F) -> (U, s, V, s - 1), the last without cancellation at small strain.
    diagonal(s) -> the matrix with s on its diagonal.
    """
    p = precision(precision_name)
    scalar, vec3, mat33 = p.scalar, p.vec3, p.mat33
    negligible = NEGLIGIBLE[precision_name]
    green_strain = strain_functions(precision_name).green_strain

    @wp.func
    def jacobi_rotation(a_pp: scalar, a_qq: scalar, a_pq: scalar, a_rp: scalar, a_rq: scalar, v_p: vec3, v_q: vec3):
        """The turn in the plane (p, q) that annihilates a_pq; r is the third axis, v the eigenvectors so far."""
        t = scalar(0.0)
        if a_pq != scalar(0.0):
            theta = (a_qq - a_pp) / (scalar(2.0) * a_pq)
            t = scalar(1.0) / (wp.abs(theta) + wp.sqrt(theta * theta + scalar(1.0)))
            if theta < scalar(0.0):
                t = -t
        c = scalar(1.0) / wp.sqrt(t * t + scalar(1.0))
        s = t * c
        return (
            a_pp - t * a_pq, a_qq + t * a_pq,
            c * a_rp - s * a_rq, s * a_rp + c * a_rq,
            c * v_p - s * v_q, s * v_p + c * v_q,
        )  # fmt: skip

    @wp.func
    def symmetric_eigen(A: mat33):
        a00, a11, a22 = A[0, 0], A[1, 1], A[2, 2]
        a01 = scalar(0.5) * (A[0, 1] + A[1, 0])
        a02 = scalar(0.5) * (A[0, 2] + A[2, 0])
        a12 = scalar(0.5) * (A[1, 2] + A[2, 1])
        v0 = vec3(scalar(1.0), scalar(0.0), scalar(0.0))
        v1 = vec3(scalar(0.0), scalar(1.0), scalar(0.0))
        v2 = vec3(scalar(0.0), scalar(0.0), scalar(1.0))
        sweep = int(0)
        limit = scalar(negligible) * (a00 * a00 + a11 * a11 + a22 * a22)
        while sweep < MAXIMUM_SWEEPS and a01 * a01 + a02 * a02 + a12 * a12 > limit:
            a00, a11, a02, a12, v0, v1 = jacobi_rotation(a00, a11, a01, a02, a12, v0, v1)
            a01 = scalar(0.0)
            a00, a22, a01, a12, v0, v2 = jacobi_rotation(a00, a22, a02, a01, a12, v0, v2)
            a02 = scalar(0.0)
            a11, a22, a01, a02, v1, v2 = jacobi_rotation(a11, a22, a12, a01, a02, v1, v2)
            a12 = scalar(0.0)
            limit = scalar(negligible) * (a00 * a00 + a11 * a11 + a22 * a22)
            sweep += 1
        return vec3(a00, a11, a22), wp.matrix_from_cols(v0, v1, v2)

    @wp.func
    def swapped(d: vec3, V: mat33, i: int, j: int):
        """Eigenpairs i and j exchanged, V still a rotation."""
        ordered = vec3(d[0], d[1], d[2])
        ordered[i] = d[j]
        ordered[j] = d[i]
        turned = mat33()
        for k in range(3):
            for row in range(3):
                turned[row, k] = V[row, k]
        for row in range(3):
            turned[row, i] = V[row, j]
            turned[row, j] = -V[row, i]
        return ordered, turned

    @wp.func
    def descending(d: vec3, V: mat33):
        if d[0] < d[1]:
            d, V = swapped(d, V, 0, 1)
        if d[1] < d[2]:
            d, V = swapped(d, V, 1, 2)
        if d[0] < d[1]:
            d, V = swapped(d, V, 0, 1)
        return d, V

    @wp.func
    def perpendicular(u: vec3):
        """A unit vector at right angles to the unit vector u."""
        axis = vec3(scalar(1.0), scalar(0.0), scalar(0.0))
        if wp.abs(u[0]) > scalar(0.7):
            axis = vec3(scalar(0.0), scalar(1.0), scalar(0.0))
        return wp.normalize(wp.cross(u, axis))

    @wp.func
    def principal_frame(F: mat33):
        e, V = symmetric_eigen(green_strain(F))
        e, V = descending(e, V)
        x0 = F * vec3(V[0, 0], V[1, 0], V[2, 0])
        x1 = F * vec3(V[0, 1], V[1, 1], V[2, 1])
        x2 = F * vec3(V[0, 2], V[1, 2], V[2, 2])
        longest = wp.length(x0)
        u0 = vec3(V[0, 0], V[1, 0], V[2, 0])  # collapsed to a point: no rotation
        u1 = vec3(V[0, 1], V[1, 1], V[2, 1])
        if longest > scalar(0.0):
            u0 = x0 / longest
            across = x1 - wp.dot(u0, x1) * u0
            width = wp.length(across)
            u1 = perpendicular(u0)  # collapsed to a line: any rotation about it
            if width * width > scalar(negligible) * longest * longest:
                u1 = across / width
        u2 = wp.cross(u0, u1)
        s = vec3(wp.dot(u0, x0), wp.dot(u1, x1), wp.dot(u2, x2))
        stretch = vec3()
        for i in range(3):
            stretch[i] = scalar(2.0) * e[i] / (scalar(1.0) + s[i])
        if s[2] < scalar(0.0):
            stretch[2] = s[2] - scalar(1.0)
        return wp.matrix_from_cols(u0, u1, u2), s, V, stretch

    @wp.func
    def diagonal(s: vec3):
        D = mat33()
        for i in range(3):
            D[i, i] = s[i]
        return D

    return SimpleNamespace(symmetric_eigen=symmetric_eigen, principal_frame=principal_frame, diagonal=diagonal)
