"""The floating-point types that one family of kernels is compiled for."""

from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import warp as wp

PARAMETER_COUNT = 6
"""Slots for the constitutive parameters of one material; unused ones are zero."""


@dataclass(frozen=True)
class Precision:
    """Warp types of one precision: scalar, 3-vector, 3x3 matrix, 3x3 of node-pair stiffness, parameters."""

    scalar: Any
    vec3: Any
    mat33: Any
    parameters: Any
    numpy: Any


@cache
def precision(name: str) -> Precision:
    """Types for "float32" or "float64"; any other name is a KeyError."""
    scalar = {"float32": wp.float32, "float64": wp.float64}[name]
    return Precision(
        scalar=scalar,
        vec3=wp.types.vector(length=3, dtype=scalar),
        mat33=wp.types.matrix(shape=(3, 3), dtype=scalar),
        parameters=wp.types.vector(length=PARAMETER_COUNT, dtype=scalar),
        numpy=np.dtype(name),
    )
