"""Motion of the coils over time, small."""

import numpy as np
from imgui_bundle import ImVec2, ImVec4, imgui, implot

from ...model.units import MM_PER_M
from ..sensor_layer import sensor_colour
from .panel_context import PanelContext

_POINTS = 300  # a curve is drawn with so many points at least, and fewer than twice as many


def draw_sensor_plot(context: PanelContext) -> None:
    """Height of every coil above its rest position; clicking goes to that time."""
    imgui.separator_text("Sensor height [mm]")
    size = ImVec2(-1, 8.6 * imgui.get_font_size())
    flags = implot.Flags_.no_legend | implot.Flags_.no_menus | implot.Flags_.no_mouse_text
    if implot.begin_plot("##sensors", size, flags.value):
        _draw_curves(context)
        implot.end_plot()


def _draw_curves(context: PanelContext) -> None:
    axis = implot.AxisFlags_
    implot.setup_axes("", "", axis.no_label.value, (axis.no_label | axis.auto_fit).value)
    implot.setup_axis_limits(implot.ImAxis_.x1, 0.0, max(context.playback.duration, 1e-3), imgui.Cond_.always)
    history, rest = context.session.history, context.session.model.sensor_rest_positions
    count = history.frame_count  # read once: the simulation may be adding frames
    every = max(1, count // _POINTS)
    time = np.ascontiguousarray(history.time[:count:every])
    height = MM_PER_M * (history.sensors[:count:every, :, 2] - rest[:, 2])
    if len(time) > 1:
        for i, name in enumerate(context.session.model.sensors.names):
            weight = 2.4 if i == context.selected_sensor else 1.4
            spec = implot.Spec(line_color=ImVec4(*sensor_colour(i), 1.0), line_weight=weight)
            implot.plot_line(name, time, np.ascontiguousarray(height[:, i]), spec=spec)
    now = np.array([context.playback.time])
    implot.plot_inf_lines("##now", now, spec=implot.Spec(line_color=ImVec4(1, 1, 1, 0.55)))
    if implot.is_plot_hovered() and imgui.is_mouse_down(imgui.MouseButton_.left):
        context.playback.seek(implot.get_plot_mouse_pos().x)
        context.playback.playing = False
