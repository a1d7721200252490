"""Keys and mouse over the 3D view."""

from collections.abc import Callable

from imgui_bundle import imgui

from .camera import VIEWS
from .panels.panel_context import PanelContext

_ORBIT = 0.0075  # [rad/point]


def key_actions(context: PanelContext) -> dict[imgui.Key, Callable[[], None]]:
    """What each key does."""
    playback, options = context.playback, context.options

    def flip(owner: object, name: str) -> Callable[[], None]:
        return lambda: setattr(owner, name, not getattr(owner, name))

    actions: dict[imgui.Key, Callable[[], None]] = {
        imgui.Key.space: playback.toggle,
        imgui.Key.left_arrow: lambda: playback.step(-1),
        imgui.Key.right_arrow: lambda: playback.step(1),
        imgui.Key.up_arrow: lambda: playback.faster(1),
        imgui.Key.down_arrow: lambda: playback.faster(-1),
        imgui.Key.home: playback.rewind,
        imgui.Key.end: lambda: playback.seek(playback.duration),
        imgui.Key.l: flip(playback, "loop"),
        imgui.Key.r: context.reset_view,
        imgui.Key.c: flip(options, "cut"),
        imgui.Key.n: flip(options, "show_labels"),
        imgui.Key.f: context.cycle_field,
    }
    digits = (imgui.Key._1, imgui.Key._2, imgui.Key._3, imgui.Key._4)
    for key, view in zip(digits, VIEWS, strict=False):
        actions[key] = lambda view=view: context.look(view)  # type: ignore[misc]
    return actions


def handle_input(context: PanelContext) -> None:
    """Applies this frame's keys and mouse; call between imgui's new frame and render."""
    io = imgui.get_io()
    if io.key_ctrl:
        context.close_requested |= imgui.is_key_pressed(imgui.Key.q)
    elif not io.want_text_input:
        for key, action in key_actions(context).items():
            if imgui.is_key_pressed(key):
                action()
    if not io.want_capture_mouse:
        _move_camera(context, io)


def _move_camera(context: PanelContext, io: imgui.IO) -> None:
    """Left drag orbits; right, middle or Shift-left drag pans; the wheel zooms; a double click resets."""
    camera, delta = context.camera, io.mouse_delta
    left = imgui.is_mouse_down(imgui.MouseButton_.left)
    other = imgui.is_mouse_down(imgui.MouseButton_.right) or imgui.is_mouse_down(imgui.MouseButton_.middle)
    if imgui.is_mouse_double_clicked(imgui.MouseButton_.left):
        context.reset_view()
    elif other or (left and io.key_shift):
        height = max(context.viewport.height, 1.0)
        camera.pan(delta.x / height, -delta.y / height)
    elif left:
        camera.orbit(_ORBIT * delta.x, -_ORBIT * delta.y)
    if io.mouse_wheel:
        camera.zoom(io.mouse_wheel)
