"""Look of the panels: dark, quiet, rounded."""

from imgui_bundle import ImVec2, ImVec4, imgui

from .fonts import font_path

ACCENT = ImVec4(0.93, 0.52, 0.47, 1.0)
"""The tongue's pink, for what is active."""

MUTED = ImVec4(0.58, 0.62, 0.68, 1.0)
WARNING = ImVec4(0.98, 0.74, 0.36, 1.0)

PANEL = ImVec4(0.098, 0.109, 0.128, 1.0)
"""Behind all panels: the colour that the window is cleared with."""

FONT_SIZE = 15.0


def apply_theme(scale: float = 1.0) -> None:
    """Sets fonts, spacing and colours of the current imgui context; `scale` for high-density screens."""
    path = font_path()
    fonts = imgui.get_io().fonts
    if path is not None:
        fonts.add_font_from_file_ttf(str(path), FONT_SIZE)
    style = imgui.get_style()
    imgui.style_colors_dark()
    style.font_scale_dpi = scale
    style.window_padding = ImVec2(14, 12)
    style.frame_padding = ImVec2(9, 5)
    style.item_spacing = ImVec2(8, 7)
    style.item_inner_spacing = ImVec2(7, 5)
    style.window_rounding = 0.0
    style.frame_rounding = style.grab_rounding = style.popup_rounding = 6.0
    style.child_rounding = 8.0
    style.window_border_size = style.frame_border_size = 0.0
    style.grab_min_size = 12.0
    style.scrollbar_size = 10.0
    style.scale_all_sizes(scale)
    _colour(style)


def _colour(style: imgui.Style) -> None:
    col = imgui.Col_
    faint, soft, strong = ImVec4(1, 1, 1, 0.055), ImVec4(1, 1, 1, 0.10), ImVec4(1, 1, 1, 0.16)
    colours = {
        col.window_bg: PANEL,
        col.popup_bg: ImVec4(0.125, 0.138, 0.160, 0.98),
        col.text: ImVec4(0.90, 0.92, 0.95, 1.0),
        col.text_disabled: MUTED,
        col.frame_bg: faint,
        col.frame_bg_hovered: soft,
        col.frame_bg_active: strong,
        col.button: faint,
        col.button_hovered: soft,
        col.button_active: strong,
        col.header: faint,
        col.header_hovered: soft,
        col.header_active: strong,
        col.check_mark: ACCENT,
        col.slider_grab: ACCENT,
        col.slider_grab_active: ImVec4(1.0, 0.62, 0.56, 1.0),
        col.separator: faint,
        col.border: ImVec4(1, 1, 1, 0.07),
    }
    for which, value in colours.items():
        style.set_color_(which, value)
