"""Constitutive laws as triples: energy density, its gradient and its Hessian with respect to F.

Every law is a function `law(precision) -> MaterialTriple` of three Warp functions
    energy(F, p)      -> Psi(F)            strain energy density [Pa]
    gradient(F, p)    -> P = dPsi/dF       first Piola-Kirchhoff stress [Pa]
    hessian(F, dF, p) -> dP = d2Psi/dF2 : dF
with p the parameter vector that `parameters` packs. A new material is one more function here and
one more entry in `MATERIALS`.
"""

from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import warp as wp

from .precision import PARAMETER_COUNT, Precision, precision


class MaterialTriple(NamedTuple):
    """Warp functions of one constitutive law."""

    energy: Any
    gradient: Any
    hessian: Any


def stvk(p: Precision) -> MaterialTriple:
    """St. Venant-Kirchhoff: Psi = mu E:E + lambda/2 tr(E)^2, P = F (2 mu E + lambda tr(E) I).

    E = (F^T F - I) / 2 is the Green strain. Source: Luo 2017, section 6.
    Parameters: p[0] = mu, p[1] = lambda [Pa].
    """
    mat33, parameters, scalar = p.mat33, p.parameters, p.scalar

    @wp.func
    def green_strain(F: mat33):
        return scalar(0.5) * (wp.transpose(F) * F - wp.identity(n=3, dtype=scalar))

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


MATERIALS: dict[str, Callable[[Precision], MaterialTriple]] = {"stvk": stvk}


def pack_parameters(model: str, lame_mu: float, lame_lambda: float) -> list[float]:
    """Parameter vector of `model`, PARAMETER_COUNT long, from the Lame parameters [Pa]."""
    if model not in MATERIALS:
        raise KeyError(model)
    return [lame_mu, lame_lambda] + [0.0] * (PARAMETER_COUNT - 2)


@cache
def material_triple(model: str, precision_name: str) -> MaterialTriple:
    """The triple of `model` compiled for one precision."""
    return MATERIALS[model](precision(precision_name))
