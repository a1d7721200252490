"""What every panel may read and change."""

from dataclasses import dataclass, field

from ...model.history import Sample
from ..camera import Camera
from ..frame_timing import FrameTiming
from ..playback import Playback
from ..scene import default_camera
from ..session_view import NO_FIELD, ScalarField, SessionView
from ..view_options import ViewOptions


@dataclass
class Viewport:
    """Where the 3D view is in the window: left, top, width, height [points], y down."""

    left: float = 0.0
    top: float = 0.0
    width: float = 1.0
    height: float = 1.0


@dataclass
class PanelContext:
    """The state of the window that panels share: all of them show and change the same time and view.

    renderer: name of the device that draws.
    sample, scalar: what is on screen now. selected_sensor: index of the coil to emphasise,
    or None. close_requested: by a key.
    """

    session: SessionView
    playback: Playback
    camera: Camera
    options: ViewOptions
    timing: FrameTiming
    renderer: str
    sample: Sample
    scalar: ScalarField | None = None
    selected_sensor: int | None = None
    viewport: Viewport = field(default_factory=Viewport)
    close_requested: bool = False

    def reset_view(self) -> None:
        """Puts the camera back to where it was when the window opened."""
        self.camera = default_camera(self.session.model)

    def look(self, view: str) -> None:
        """Frames the tongue from a built-in view."""
        self.camera = default_camera(self.session.model, view)

    def cycle_field(self) -> None:
        """Shows the next scalar on the tongue."""
        names = self.session.field_names() or (NO_FIELD,)
        at = names.index(self.options.field_name) if self.options.field_name in names else -1
        self.options.field_name = names[(at + 1) % len(names)]
