"""Warp functions of the deformation gradient, written in G = F - I so that small strains keep their digits.

F^T F - I and det F - 1 lose as many digits as the strain is small; in single precision that is most of what a
tongue near rest has. Every function here is a polynomial in G instead, without a difference of large terms.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp

from .precision import precision


@cache
def strain_functions(precision_name: str) -> SimpleNamespace:
    """Warp functions of one precision, of the deformation gradient F (3x3, dx_i/dX_j).

    displacement_gradient(F) -> G = F - I.
    green_strain(F) -> E = (F^T F - I) / 2 = sym(G) + G^T G / 2.
    cofactor(F) -> cof F = d(det F)/dF, also where F is singular.
    cofactor_product(F, dF) -> d(cof F)/dF : dF.
    second_invariant(A) -> (tr(A)^2 - tr(A A)) / 2 = tr(cof A).
    volume_change(F) -> det F - 1.
    """
    p = precision(precision_name)
    scalar, vec3, mat33 = p.scalar, p.vec3, p.mat33

    @wp.func
    def displacement_gradient(F: mat33):
        return F - wp.identity(n=3, dtype=scalar)

    @wp.func
    def green_strain(F: mat33):
        G = displacement_gradient(F)
        return scalar(0.5) * (G + wp.transpose(G) + wp.transpose(G) * G)

    @wp.func
    def row(A: mat33, i: int):
        return vec3(A[i, 0], A[i, 1], A[i, 2])

    @wp.func
    def cofactor(F: mat33):
        a, b, c = row(F, 0), row(F, 1), row(F, 2)
        return wp.matrix_from_rows(wp.cross(b, c), wp.cross(c, a), wp.cross(a, b))

    @wp.func
    def cofactor_product(F: mat33, dF: mat33):
        a, b, c = row(F, 0), row(F, 1), row(F, 2)
        da, db, dc = row(dF, 0), row(dF, 1), row(dF, 2)
        return wp.matrix_from_rows(
            wp.cross(db, c) + wp.cross(b, dc),
            wp.cross(dc, a) + wp.cross(c, da),
            wp.cross(da, b) + wp.cross(a, db),
        )

    @wp.func
    def second_invariant(A: mat33):
        return (
            A[0, 0] * A[1, 1] - A[0, 1] * A[1, 0]
            + A[0, 0] * A[2, 2] - A[0, 2] * A[2, 0]
            + A[1, 1] * A[2, 2] - A[1, 2] * A[2, 1]
        )  # fmt: skip

    @wp.func
    def volume_change(F: mat33):
        G = displacement_gradient(F)
        return wp.trace(G) + second_invariant(G) + wp.determinant(G)

    return SimpleNamespace(
        displacement_gradient=displacement_gradient,
        green_strain=green_strain,
        cofactor=cofactor,
        cofactor_product=cofactor_product,
        second_invariant=second_invariant,
        volume_change=volume_change,
    )
