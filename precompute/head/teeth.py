"""Crowns of the teeth as signed distances in each tooth's frame (mm).

Local coordinates: s along the arch, t outward (facial), h from the neck (0) towards the edge (height). Crowns
go on below the gum line, where the gum hides them.
"""

import numpy as np

from .arch import ToothFrame
from .shapes import Array, monotone, smooth_intersection, smooth_union, superellipse

ROOT_DEPTH = 1.8
"""How far a crown's surface is drawn below its neck [mm]."""

# Outlines over the relative height (0 neck, 1 edge), as parts of half the width or depth.
_LEVEL = [-0.5, 0.0, 0.2, 0.45, 0.7, 0.9, 1.0]
_FACIAL = {  # outward surface
    "incisor": monotone(_LEVEL, [0.62, 0.86, 0.98, 0.97, 0.82, 0.62, 0.52]),
    "canine": monotone(_LEVEL, [0.62, 0.88, 1.00, 0.98, 0.80, 0.52, 0.38]),
    "premolar": monotone(_LEVEL, [0.70, 0.90, 0.99, 0.98, 0.88, 0.74, 0.66]),
    "molar": monotone(_LEVEL, [0.76, 0.92, 1.00, 0.99, 0.90, 0.78, 0.70]),
}
_LINGUAL = {  # inward surface; incisors are hollow above the cingulum
    "incisor": monotone(_LEVEL, [0.66, 0.90, 0.92, 0.50, 0.10, -0.08, -0.12]),
    "canine": monotone(_LEVEL, [0.66, 0.92, 0.96, 0.66, 0.28, 0.02, -0.06]),
    "premolar": monotone(_LEVEL, [0.70, 0.88, 0.96, 1.00, 0.92, 0.76, 0.66]),
    "molar": monotone(_LEVEL, [0.76, 0.90, 0.97, 1.00, 0.92, 0.80, 0.72]),
}
_SQUARENESS = {"incisor": 2.3, "canine": 2.1, "premolar": 2.4, "molar": 3.0}

# Cusps: (s, t) as parts of half the width and depth, height below the highest [mm].
_CUSPS = {
    "premolar": ((0.0, 0.50, 0.0), (0.0, -0.52, 0.9)),
    "molar": ((-0.46, 0.52, 0.2), (0.46, 0.52, 0.4), (-0.46, -0.52, 0.0), (0.46, -0.52, 0.3)),
}


def crown(points: Array, frame: ToothFrame) -> Array:
    """Distance of points (n, 3), arch's frame, to a crown, (n,)."""
    tooth = frame.tooth
    s, t, h = frame.local(points).T
    s = s * frame.mirrored_distally()
    level = h / tooth.height
    side = _sides(s, t, level, frame)
    top = _incisal(s, t, h, frame) if tooth.kind in ("incisor", "canine") else _occlusal(s, t, h, frame)
    rounding = 0.9 if tooth.kind in ("incisor", "canine") else 2.2
    body = smooth_intersection(side, top, rounding)
    return smooth_intersection(body, -(h + ROOT_DEPTH), 1.8)


def _sides(s: Array, t: Array, level: Array, frame: ToothFrame) -> Array:
    """Outline across the crown: a superellipse whose extents change over the height."""
    tooth = frame.tooth
    neck = tooth.neck
    wide = monotone(_LEVEL, [0.85 * neck, neck, 0.5 + 0.5 * neck, 0.96, 1.0, 0.99, 0.96])
    a = 0.5 * tooth.width * wide(level)
    outer = 0.5 * tooth.depth * _FACIAL[tooth.kind](level)
    inner = 0.5 * tooth.depth * _LINGUAL[tooth.kind](level)
    return superellipse(s, t - (outer - inner) / 2.0, a, (outer + inner) / 2.0, _SQUARENESS[tooth.kind])


def _incisal(s: Array, t: Array, h: Array, frame: ToothFrame) -> Array:
    """Above the edge of an incisor, slightly bowed, or of a canine, pointed."""
    tooth = frame.tooth
    u = 2.0 * s / tooth.width
    if tooth.kind == "canine":
        drop = 0.24 * tooth.height * (np.sqrt(u**2 + 0.03) - 0.173)
        return (h - tooth.height + drop) * 0.85
    distal = np.maximum(u, 0.0)
    return h - tooth.height + 0.35 * u**2 + 0.55 * distal**3


def _occlusal(s: Array, t: Array, h: Array, frame: ToothFrame) -> Array:
    """Above the chewing surface: rounded cusps around a fossa, joined by ridges."""
    tooth = frame.tooth
    a, b = tooth.width / 2.0, tooth.depth / 2.0
    slope = 0.62
    surface = np.full(len(s), -3.0)
    for u, v, below in _CUSPS[tooth.kind]:
        away = np.sqrt((s - u * a) ** 2 + (0.9 * (t - v * b)) ** 2 + 0.35)
        surface = -smooth_union(-surface, -(-below - slope * (away - 0.59)), 0.35)
    rim = -1.1 - 0.25 * ((np.abs(s) / a - 0.84) * a / 0.8) ** 2  # marginal ridges close the fossa
    surface = -smooth_union(-surface, -np.maximum(rim, -3.0), 0.5)
    return (h - tooth.height - surface) * 0.8
