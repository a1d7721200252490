"""Constitutive laws, one a file, each a triple of Warp functions: energy density, its gradient and its Hessian.

A new law is one more file with a function `law(precision) -> MaterialTriple` and one more entry in `MATERIALS`.
"""

from collections.abc import Callable
from functools import cache
from typing import NamedTuple

from ..precision import PARAMETER_COUNT, Precision, precision
from .corotational import corotational
from .mooney_rivlin import mooney_rivlin
from .neo_hookean import neo_hookean
from .stvk import stvk
from .triple import MaterialTriple

__all__ = ["MATERIALS", "Law", "MaterialTriple", "material_triple", "pack_parameters"]


class Law(NamedTuple):
    """A constitutive law: how its triple is made, and the names of the constants that it takes, in order."""

    triple: Callable[[Precision], MaterialTriple]
    constants: tuple[str, ...]


LAME = ("lame_mu", "lame_lambda")

MATERIALS: dict[str, Law] = {
    "stvk": Law(stvk, LAME),
    "neo-hookean": Law(neo_hookean, LAME),
    "corotational": Law(corotational, LAME),
    "mooney-rivlin": Law(mooney_rivlin, ("c10", "c01", "c11", "c20", "c02", "bulk_modulus")),
}


def pack_parameters(model: str, *constants: float) -> list[float]:
    """Parameter vector of `model`, PARAMETER_COUNT long, from its constants [Pa] in the law's order.

    Raises KeyError for a law that there is not, ValueError for another number of constants than it takes.
    """
    names = MATERIALS[model].constants
    if len(constants) != len(names):
        raise ValueError(f"{model} takes {', '.join(names)}")
    return [*constants, *([0.0] * (PARAMETER_COUNT - len(names)))]


@cache
def material_triple(model: str, precision_name: str) -> MaterialTriple:
    """The triple of `model` compiled for one precision."""
    return MATERIALS[model].triple(precision(precision_name))
