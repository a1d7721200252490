"""Colour maps that colour-blind eyes can read, from a few control points each.

"viridis" and "magma" are perceptually uniform and sequential (van der Walt and Smith, matplotlib 2.0);
"diverging" runs blue - pale - orange brown with lightness symmetric about its middle, after the
vik map of Crameri (2018). Control points are interpolated in CIE Lab, where equal steps look equal.
"""

from functools import cache

import numpy as np
from numpy.typing import NDArray

CONTROL_POINTS = {
    "viridis": "440154 482878 3e4a89 31688e 26828e 1f9e89 35b779 6ece58 b5de2b fde725",
    "magma": "000004 180f3d 440f76 721f81 9e2f7f cd4071 f1605d fd9668 feca8d fcfdbf",
    "diverging": "0b2c5f 1f5a93 4e8fbd 97c0db f0ece6 e5bb98 cb8254 a44a22 68210f",
}
"""sRGB colours at even steps from low to high."""

_GOLDEN_ANGLE = 137.50776
_FIRST_HUE = 250.0  # blue
_CHROMA = 46.0

_LINEAR_TO_XYZ = np.array([[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]])
_WHITE = _LINEAR_TO_XYZ.sum(axis=1)


@cache
def colour_table(name: str, size: int = 256) -> NDArray[np.uint8]:
    """The map as sRGB bytes from low to high, (size, 3); of "categories" one colour each."""
    if name == "categories":
        return _category_table(size)
    points = np.array([[int(c[i : i + 2], 16) for i in (0, 2, 4)] for c in CONTROL_POINTS[name].split()]) / 255.0
    lab = _lab(srgb_to_linear(points))
    at = np.linspace(0.0, len(points) - 1.0, size)
    fine = np.stack([np.interp(at, np.arange(len(points)), lab[:, k]) for k in range(3)], axis=1)
    table = np.round(255.0 * linear_to_srgb(np.clip(_from_lab(fine), 0.0, 1.0))).astype(np.uint8)
    table.setflags(write=False)
    return table


def _category_table(size: int) -> NDArray[np.uint8]:
    """Colours that tell categories apart: hues a golden angle apart in CIE Lab, in four lightnesses.

    Hues nearly return after 13, 21 or 34 steps, which four does not divide.
    """
    index = np.arange(size)
    hue = np.deg2rad(_FIRST_HUE + _GOLDEN_ANGLE * index)
    lightness = np.array([68.0, 54.0, 82.0, 42.0])[index % 4]
    lab = np.stack([lightness, _CHROMA * np.cos(hue), _CHROMA * np.sin(hue)], axis=1)
    table = np.round(255.0 * linear_to_srgb(np.clip(_from_lab(lab), 0.0, 1.0))).astype(np.uint8)
    table.setflags(write=False)
    return table


def srgb_to_linear(colour: NDArray[np.floating]) -> NDArray[np.float64]:
    """Display values in [0, 1] to light, any shape."""
    c = np.asarray(colour, dtype=np.float64)
    return np.where(c <= 0.04045, c / 12.92, ((c + 0.055) / 1.055) ** 2.4)


def linear_to_srgb(light: NDArray[np.floating]) -> NDArray[np.float64]:
    """Light in [0, 1] to display values, any shape."""
    c = np.asarray(light, dtype=np.float64)
    return np.where(c <= 0.0031308, 12.92 * c, 1.055 * np.maximum(c, 1e-9) ** (1 / 2.4) - 0.055)


def _lab(linear: NDArray[np.float64]) -> NDArray[np.float64]:
    t = linear @ _LINEAR_TO_XYZ.T / _WHITE
    f = np.where(t > 0.008856, np.cbrt(t), 7.787 * t + 16.0 / 116.0)
    return np.stack([116 * f[:, 1] - 16, 500 * (f[:, 0] - f[:, 1]), 200 * (f[:, 1] - f[:, 2])], axis=1)


def _from_lab(lab: NDArray[np.float64]) -> NDArray[np.float64]:
    y = (lab[:, 0] + 16.0) / 116.0
    f = np.stack([y + lab[:, 1] / 500.0, y, y - lab[:, 2] / 200.0], axis=1)
    t = np.where(f > 0.206893, f**3, (f - 16.0 / 116.0) / 7.787)
    return (t * _WHITE) @ np.linalg.inv(_LINEAR_TO_XYZ).T
