"""Dimensions of the head in mm, each with its source.

Sources:
  [Ash]     Ash and Nelson, "Wheeler's Dental Anatomy, Physiology and Occlusion", table of measurements of
            the teeth: averages to which individual teeth are carved.
  [Bonwill] Bonwill's equilateral triangle of about 4 inches between the condyles and the mesial contact of
            the lower central incisors, in any textbook of occlusion.
  [chosen]  our own: a value inside the range that anatomy textbooks and midsagittal images of adults show,
            tuned so that the parts fit each other.

Coordinates: head frame, x anterior, y left, z up, origin at the upper incisors' edge, mm.
"""

from dataclasses import asdict, dataclass, field

TOOTH_NAMES = (
    "central incisor",
    "lateral incisor",
    "canine",
    "first premolar",
    "second premolar",
    "first molar",
    "second molar",
)


@dataclass(frozen=True)
class Tooth:
    """One crown: height from neck to edge, mesiodistal width, faciolingual depth, and its lean.

    kind: "incisor", "canine", "premolar" or "molar". lean [degrees]: of the crown's axis, outward positive
    [chosen]. neck: mesiodistal width at the neck as a part of the largest. rise: how far the edge stands
    beyond the occlusal plane [chosen].
    """

    kind: str
    height: float
    width: float
    depth: float
    lean: float
    neck: float
    rise: float = 0.0


def _upper_teeth() -> tuple[Tooth, ...]:
    return (  # height, width, depth and neck: [Ash]
        Tooth("incisor", 10.5, 8.5, 7.0, 18.0, 0.82),
        Tooth("incisor", 9.0, 6.5, 6.0, 16.0, 0.77, -0.5),
        Tooth("canine", 10.0, 7.5, 8.0, 8.0, 0.73, 0.5),
        Tooth("premolar", 8.5, 7.0, 9.0, 2.0, 0.71),
        Tooth("premolar", 8.5, 7.0, 9.0, 2.0, 0.71),
        Tooth("molar", 7.5, 10.0, 11.0, 4.0, 0.80),
        Tooth("molar", 7.0, 9.0, 11.0, 6.0, 0.78),
    )


def _lower_teeth() -> tuple[Tooth, ...]:
    return (  # height, width, depth and neck: [Ash]
        Tooth("incisor", 9.0, 5.0, 6.0, 12.0, 0.70),
        Tooth("incisor", 9.5, 5.5, 6.5, 11.0, 0.73),
        Tooth("canine", 11.0, 7.0, 7.5, 5.0, 0.79, 1.0),
        Tooth("premolar", 8.5, 7.0, 7.5, -3.0, 0.71, 0.3),
        Tooth("premolar", 8.0, 7.0, 8.0, -6.0, 0.71),
        Tooth("molar", 7.5, 11.0, 10.5, -10.0, 0.82),
        Tooth("molar", 7.0, 10.5, 10.0, -13.0, 0.76),
    )


@dataclass(frozen=True)
class HeadAnatomy:
    """Every number from which the head is built, mm unless said otherwise."""

    upper_teeth: tuple[Tooth, ...] = field(default_factory=_upper_teeth)
    lower_teeth: tuple[Tooth, ...] = field(default_factory=_lower_teeth)

    # Dental arches: half-widths between the crowns' middles [chosen: about 35 mm between the upper
    # canines' cusps and 50 mm between the first molars' central fossae, the lower arch inside].
    upper_arch: tuple[tuple[float, float], ...] = (
        (-1.5, 0.0),
        (-3.2, 9.0),
        (-8.6, 17.0),
        (-20.0, 22.2),
        (-31.0, 25.3),
        (-43.0, 27.8),
        (-52.0, 29.0),
    )
    lower_arch: tuple[tuple[float, float], ...] = (
        (-3.6, 0.0),
        (-4.9, 7.2),
        (-9.6, 14.2),
        (-20.0, 19.9),
        (-31.0, 23.5),
        (-43.0, 26.7),
        (-52.0, 28.7),
    )
    overbite: float = 2.0  # [chosen: 2 to 3 mm is usual]
    rest_opening: float = 6.5  # way of the lower incisors' edge from bite to rest [chosen]

    # Mandible in bite; by [Bonwill] the condyles are about 100 mm from the incisors and from each other.
    condyle: tuple[float, float, float] = (-84.0, 50.0, 37.0)
    gonion: tuple[float, float, float] = (-76.0, 47.0, -22.0)  # ramus about 60 mm high [chosen]
    menton: tuple[float, float, float] = (-10.0, 0.0, -37.0)  # symphysis about 32 mm high [chosen]
    body_thickness: float = 11.0  # [chosen]
    ramus_thickness: float = 7.0  # [chosen]

    # Palate: the vault is about 20 mm above the incisors' edge and 34 mm wide at the first molars [chosen].
    palate_height: float = 20.0
    palate_thickness: float = 4.0
    velum_length: float = 33.0

    # Hyoid: body 24 mm wide, greater horns 30 mm long [chosen].
    hyoid_centre: tuple[float, float, float] = (-58.5, 0.0, -44.5)
    hyoid_half_width: float = 12.0
    hyoid_horn_length: float = 30.0

    # Tongue: midsagittal outline at rest, from the tip over the dorsum to the vallecula, along the floor
    # to the genial tubercle and under the blade back to the tip [chosen, within the ranges that
    # midsagittal images of adults show: 85 to 100 mm from tip to epiglottis along the surface].
    tongue_outline: tuple[tuple[float, float], ...] = (
        (-8.2, -6.2),
        (-10.4, -3.0),
        (-15.5, 0.4),
        (-22.0, 4.2),
        (-30.0, 7.9),
        (-40.0, 10.4),
        (-49.0, 9.6),
        (-57.0, 4.6),
        (-63.6, -4.0),
        (-67.0, -14.0),
        (-68.2, -24.0),
        (-67.2, -33.0),
        (-62.6, -39.4),
        (-55.0, -43.0),
        (-45.0, -44.4),
        (-35.0, -43.6),
        (-27.0, -40.6),
        (-22.3, -36.0),
        (-22.9, -30.0),
        (-25.4, -23.4),
        (-26.6, -17.2),
        (-21.0, -12.9),
        (-13.5, -10.0),
        (-9.4, -8.4),
    )

    def key(self) -> dict[str, object]:
        """All values, JSON-serialisable, to recognise what was built from them."""
        return asdict(self)
