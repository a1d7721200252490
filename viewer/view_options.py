"""What the user has chosen to see; panels write it, the scene reads it."""

from dataclasses import dataclass, field

from .session_view import NO_FIELD

BACKDROPS = ("dark", "light", "transparent")


@dataclass
class ViewOptions:
    """Choices that change the picture but not the session.

    field_name: name of the scalar on the tongue (SessionView.field_names).
    show_tissue: per tissue of a RigidSurface ("bone", "tooth", "mucosa"), whether it is drawn; yes where
        it is not named.
    opacity: factor on every tissue's own opacity.
    show_sensors, show_labels, show_targets: the coils, their names, their targets where these differ.
    show_caption: title and time, in pictures. show_colour_bar: the field's colours and values, in pictures.
    cut: midsagittal clipping plane.
    backdrop: one of BACKDROPS.
    """

    field_name: str = NO_FIELD
    show_tissue: dict[str, bool] = field(default_factory=dict)
    opacity: float = 1.0
    show_tongue: bool = True
    show_sensors: bool = True
    show_labels: bool = True
    show_targets: bool = True
    show_caption: bool = False
    show_colour_bar: bool = True
    cut: bool = False
    backdrop: str = "dark"
