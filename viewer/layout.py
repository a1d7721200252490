"""Where the panels are: a side bar on the right, the transport below, the view in the rest."""

from imgui_bundle import ImVec2, imgui

from .panels.annotations import draw_annotations
from .panels.display import draw_display
from .panels.messages import draw_messages
from .panels.panel_context import PanelContext, Viewport
from .panels.performance import draw_performance
from .panels.sensor_plot import draw_sensor_plot
from .panels.transport import draw_transport
from .theme import FONT_SIZE

_SIDE_WIDTH = 18.5  # in letters' heights
_TRANSPORT_HEIGHT = 5.9
_FIXED = (
    imgui.WindowFlags_.no_decoration
    | imgui.WindowFlags_.no_move
    | imgui.WindowFlags_.no_saved_settings
    | imgui.WindowFlags_.no_bring_to_front_on_focus
    | imgui.WindowFlags_.no_background  # the window is cleared with the panels' colour
).value


def arrange(width: float, height: float) -> Viewport:
    """The view's share of a window of width x height [points]; a tiny window is all view."""
    letter = FONT_SIZE * imgui.get_style().font_scale_dpi
    side, below = _SIDE_WIDTH * letter, _TRANSPORT_HEIGHT * letter
    if width < 2.0 * side or height < 2.5 * below:
        return Viewport(0.0, 0.0, max(width, 1.0), max(height, 1.0))
    return Viewport(0.0, 0.0, width - side, height - below)


def draw_panels(context: PanelContext, width: float, height: float) -> None:
    """Draws every panel around `context.viewport`; call between imgui's new frame and render."""
    view = context.viewport
    draw_annotations(context)
    draw_messages(context)
    if view.width >= width:
        return
    _begin("##side", view.width, 0.0, width - view.width, height)
    draw_display(context)
    draw_sensor_plot(context)
    draw_performance(context)
    imgui.end()
    _begin("##transport", 0.0, view.height, view.width, height - view.height)
    draw_transport(context)
    imgui.end()


def _begin(name: str, left: float, top: float, width: float, height: float) -> None:
    imgui.set_next_window_pos(ImVec2(left, top))
    imgui.set_next_window_size(ImVec2(width, height))
    imgui.begin(name, None, _FIXED)
