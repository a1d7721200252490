"""Play, pause, step, scrub, speed."""

from imgui_bundle import ImVec2, imgui

from ..playback import SPEEDS
from ..theme import ACCENT, MUTED
from .panel_context import PanelContext


def draw_transport(context: PanelContext) -> None:
    """Time line above, buttons below."""
    _draw_time_line(context)
    _draw_buttons(context)
    _draw_status(context)


def _draw_time_line(context: PanelContext) -> None:
    """A bar over the whole trajectory: simulated part, and a handle at the time on screen."""
    playback = context.playback
    width, height = imgui.get_content_region_avail().x, 22.0 * imgui.get_style().font_scale_dpi
    corner = imgui.get_cursor_screen_pos()
    imgui.invisible_button("time line", ImVec2(max(width, 1.0), height))
    duration = max(playback.duration, 1e-9)
    if imgui.is_item_active():
        playback.seek((imgui.get_io().mouse_pos.x - corner.x) / max(width, 1.0) * duration)
        playback.playing = False
    draw = imgui.get_window_draw_list()
    middle, half = corner.y + 0.5 * height, 3.0
    handle = corner.x + width * min(playback.time / duration, 1.0)

    def bar(fraction: float, colour: tuple[float, float, float, float]) -> None:
        end = corner.x + max(width * min(fraction, 1.0), 2.0 * half)
        draw.add_rect_filled(
            ImVec2(corner.x, middle - half), ImVec2(end, middle + half), imgui.get_color_u32(colour), half
        )

    bar(1.0, (1.0, 1.0, 1.0, 0.08))
    bar(playback.frontier / duration, (1.0, 1.0, 1.0, 0.22))
    bar(playback.time / duration, (ACCENT.x, ACCENT.y, ACCENT.z, 1.0))
    radius = 8.0 if imgui.is_item_hovered() or imgui.is_item_active() else 6.5
    draw.add_circle_filled(ImVec2(handle, middle), radius, imgui.get_color_u32((0.97, 0.97, 0.98, 1.0)))


def _draw_buttons(context: PanelContext) -> None:
    playback = context.playback
    if imgui.button("Pause" if playback.playing else "Play", ImVec2(imgui.get_font_size() * 4.2, 0)):
        playback.toggle()
    imgui.set_item_tooltip("Space")
    imgui.same_line()
    for label, frames, key in (("- 1", -1, "Left"), ("+ 1", 1, "Right")):
        if imgui.button(label):
            playback.step(frames)
        imgui.set_item_tooltip(f"One simulation step ({key} arrow)")
        imgui.same_line()
    if imgui.button("Start"):
        playback.rewind()
    imgui.set_item_tooltip("Home")
    imgui.same_line()
    imgui.set_next_item_width(imgui.get_font_size() * 5.6)
    if imgui.begin_combo("##speed", f"{playback.speed:g}x"):
        for speed in SPEEDS:
            if imgui.selectable(f"{speed:g}x", speed == playback.speed)[0]:
                playback.speed = speed
        imgui.end_combo()
    imgui.set_item_tooltip("Speed (Down and Up arrows)")
    imgui.same_line()
    playback.loop = imgui.checkbox("Loop", playback.loop)[1]
    imgui.set_item_tooltip("L")


def _draw_status(context: PanelContext) -> None:
    """Time on the right end of the row, and what playback waits for."""
    playback = context.playback
    text = f"{playback.time:6.2f} / {playback.duration:.2f} s"
    if playback.waiting:
        text = f"simulating ...   {text}"
    elif playback.frontier < playback.duration - 1e-6 and context.session.failure is None:
        text = f"simulated {playback.frontier:.2f} s   {text}"
    right = imgui.get_window_width() - imgui.get_style().window_padding.x - imgui.calc_text_size(text).x
    imgui.same_line(max(right, 0.0))
    imgui.align_text_to_frame_padding()
    imgui.text_colored(MUTED if playback.waiting else imgui.get_style_color_vec4(imgui.Col_.text), text)
