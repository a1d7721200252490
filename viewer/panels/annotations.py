"""What is written over the 3D view: names of the coils, the colour bar."""

import numpy as np
from imgui_bundle import ImVec2, imgui

from ..colour_bar import labelled_ticks, listed
from ..colour_map import colour_table
from ..labels import label_corners
from ..overlay import INK
from ..session_view import ScalarField
from .panel_context import PanelContext

_BAR_STEPS = 48


def draw_annotations(context: PanelContext) -> None:
    """Draws behind the panels, over the view."""
    view = context.viewport
    draw = imgui.get_background_draw_list()
    draw.push_clip_rect(ImVec2(view.left, view.top), ImVec2(view.left + view.width, view.top + view.height))
    if context.options.show_sensors and context.options.show_labels:
        _draw_names(context, draw)
    if context.scalar is not None:
        _draw_colour_bar(context, context.scalar, draw)
    draw.pop_clip_rect()


def _draw_names(context: PanelContext, draw: imgui.ImDrawList) -> None:
    view, sample = context.viewport, context.sample
    at = context.camera.project(sample.sensors + sample.jaw_translation, view.width, view.height)[:, :2]
    plate = imgui.get_color_u32((0.063, 0.075, 0.094, 0.62))
    ink = imgui.get_color_u32((0.91, 0.925, 0.95, 1.0))
    names = context.session.model.sensors.names
    texts = [imgui.calc_text_size(name) for name in names]
    sizes = np.array([(text.x + 12.0, text.y + 6.0) for text in texts]).reshape(-1, 2)
    for name, size, (x, y) in zip(names, sizes, label_corners(at, sizes, 9.0), strict=True):
        if np.isfinite(x) and np.isfinite(y):
            left, top = view.left + x, view.top + y
            draw.add_rect_filled(ImVec2(left, top), ImVec2(left + size[0], top + size[1]), plate, 5.0)
            draw.add_text(ImVec2(left + 6.0, top + 3.0), ink, name)


def _draw_colour_bar(context: PanelContext, scalar: ScalarField, draw: imgui.ImDrawList) -> None:
    """Title, ramp, ticks at the right edge of the view."""
    view, unit = context.viewport, imgui.get_font_size() / 15.0
    red, green, blue = INK[context.options.backdrop]
    ink = imgui.get_color_u32((red / 255, green / 255, blue / 255, 1.0))
    right, top = view.left + view.width - 22 * unit, view.top + 46 * unit
    left, height = right - 14 * unit, max(0.36 * view.height, 1.0)
    title = imgui.calc_text_size(scalar.title)
    draw.add_text(ImVec2(right - title.x, view.top + 18 * unit), ink, scalar.title)
    if scalar.categories:
        _draw_categories(scalar.categories, ImVec2(right, top), view.top + view.height, ink, draw)
        return
    colours = colour_table(scalar.map_name, _BAR_STEPS + 1)[::-1] / 255.0
    packed = [imgui.get_color_u32((r, g, b, 1.0)) for r, g, b in colours]
    for i in range(_BAR_STEPS):
        y0, y1 = top + height * i / _BAR_STEPS, top + height * (i + 1) / _BAR_STEPS
        draw.add_rect_filled_multi_color(
            ImVec2(left, y0), ImVec2(right, y1), packed[i], packed[i], packed[i + 1], packed[i + 1]
        )
    for at, text in labelled_ticks(*scalar.span):
        y = top + (1.0 - at) * height
        draw.add_line(ImVec2(left - 5 * unit, y), ImVec2(left - unit, y), ink)
        size = imgui.calc_text_size(text)
        draw.add_text(ImVec2(left - 9 * unit - size.x, y - 0.5 * size.y), ink, text)


def _draw_categories(
    categories: tuple[str, ...], corner: ImVec2, bottom: float, ink: int, draw: imgui.ImDrawList
) -> None:
    """A swatch with its name for each category, from the top right `corner` down to `bottom` at most."""
    unit = imgui.get_font_size() / 15.0
    line = 22 * unit
    texts = listed(categories, max(1, int((bottom - corner.y) / line) - 1))
    colours = colour_table("categories") / 255.0
    for k, text in enumerate(texts):
        y = corner.y + k * line
        size = imgui.calc_text_size(text)
        draw.add_text(ImVec2(corner.x - 22 * unit - size.x, y), ink, text)
        if k < len(categories) and text == categories[k]:
            colour = imgui.get_color_u32((*colours[k], 1.0))
            draw.add_rect_filled(ImVec2(corner.x - 14 * unit, y), ImVec2(corner.x, y + 14 * unit), colour, 3.0)
