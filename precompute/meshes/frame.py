"""From a file's unit, axes and origin to metres in the head frame (x anterior, y left, z up)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...model.errors import LingualError
from .warning import warn

UNITS = {"m": 1.0, "cm": 0.01, "mm": 0.001}
"""Metres in the units that have names."""

TONGUE_LENGTH = (0.04, 0.15)
"""Longest edge of a tongue's bounding box, with room on both sides of the usual 50 to 120 mm [m]."""


@dataclass(frozen=True)
class MeshFrame:
    """x_head = unit * axes @ (x_file - origin).

    unit: metres in a unit of the file. axes: which file axes point anterior, left and up, e.g.
    "-x +z +y". origin: the point of the file [file unit] that becomes the origin of the head frame.

    Raises LingualError for a unit that is not positive, or axes that are no rotation.
    """

    unit: float = 1.0
    axes: str = "+x +y +z"
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not (np.isfinite(self.unit) and self.unit > 0.0):
            raise LingualError(f"The unit of a mesh is {self.unit} m; it must be positive.")
        axis_matrix(self.axes)

    def to_head(self, points: NDArray[np.floating]) -> NDArray[np.float64]:
        """Points (n, 3) of the file in the head frame [m]."""
        centred = np.asarray(points, dtype=np.float64) - self.origin
        return self.unit * (centred @ axis_matrix(self.axes).T)


def axis_matrix(axes: str) -> NDArray[np.float64]:
    """The rotation (3, 3) of axes such as "-x +z +y": row i picks what points anterior, left, up.

    Raises LingualError for another form, an axis that appears twice, or a reflection.
    """
    names = axes.split()
    if len(names) != 3 or sorted(name[1:] for name in names) != ["x", "y", "z"]:
        raise LingualError(
            f"The axes of a mesh are '{axes}'; write which of its axes point anterior, left and up, "
            "such as '-x +z +y'."
        )
    matrix = np.zeros((3, 3))
    for row, name in enumerate(names):
        if name[0] not in "+-":
            raise LingualError(f"The axes of a mesh are '{axes}'; each needs a sign, such as '-x +z +y'.")
        matrix[row, "xyz".index(name[1])] = 1.0 if name[0] == "+" else -1.0
    if np.linalg.det(matrix) < 0.0:
        raise LingualError(f"The axes '{axes}' of a mesh would mirror it; change the sign of the second.")
    return matrix


def parse_unit(text: str | float) -> float:
    """Metres in a unit given as m, cm, mm or a number of metres. Raises LingualError otherwise."""
    if isinstance(text, str) and text.strip().lower() in UNITS:
        return UNITS[text.strip().lower()]
    try:
        unit = float(text)
    except ValueError:
        unit = float("nan")
    if not (np.isfinite(unit) and unit > 0.0):
        raise LingualError(f"The unit '{text}' is not known; give m, cm, mm or the metres in one unit.")
    return unit


def guessed_unit(points: NDArray[np.floating], source: str) -> float:
    """Metres in a unit of the file, from the size that a tongue has; told by a MeshWarning.

    Raises LingualError when neither m, cm nor mm gives such a size.
    """
    length = float(np.ptp(points, axis=0).max())
    for name, unit in UNITS.items():
        if TONGUE_LENGTH[0] <= length * unit <= TONGUE_LENGTH[1]:
            warn(
                source,
                f"its unit is not given; {name} is assumed: it is {length * unit * 1e3:.0f} mm long then.",
            )
            return unit
    raise LingualError(
        f"{source} is {length:.4g} units long, which is no tongue in m, cm or mm; give its unit."
    )
