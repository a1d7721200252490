"""What the rigid parts of the mouth look like."""

from dataclasses import dataclass

Opacity = tuple[float, float]
"""Facing the eye and at grazing view."""


@dataclass(frozen=True)
class Tissue:
    """Look of a rigid tissue.

    reflectance: diffuse, linear RGB. opacity: of what lies free; at_teeth: of what covers the necks and
    roots of teeth, which must not shine through. gloss: of highlights. veil: only its nearest layer is
    seen, and none of it through other tissue.
    """

    reflectance: tuple[float, float, float]
    opacity: Opacity
    at_teeth: Opacity
    gloss: float
    veil: bool = False


TISSUES = {
    "bone": Tissue((0.95, 0.64, 0.35), (0.25, 0.90), (0.25, 0.90), 0.28, veil=True),
    "tooth": Tissue((0.68, 0.605, 0.465), (1.0, 1.0), (1.0, 1.0), 0.5),
    "mucosa": Tissue((0.66, 0.245, 0.235), (0.11, 0.60), (0.84, 0.96), 0.16),
}
"""Looks by RigidSurface.tissue; an unknown tissue looks like bone."""

TISSUE_INDEX = {name: i for i, name in enumerate(TISSUES)}


def tissue_index(name: str) -> int:
    """Place of a tissue in TISSUES; 0 (bone) for an unknown one."""
    return TISSUE_INDEX.get(name, TISSUE_INDEX["bone"])
