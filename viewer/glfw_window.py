"""Opening a window with OpenGL 4.1, and what the screen it is on wants."""

import sys
from typing import Any

from ..model import LingualError
from .context import is_software, window_context
from .glfw_library import glfw

GlfwWindow = Any
"""pyGLFW's opaque handle of a window."""


def open_window(title: str, width: int, height: int, samples: int | None) -> GlfwWindow:
    """A glfw window of width x height [points] whose context is current on this thread.

    samples: multisampling; None takes 4 on a graphics card and none when the processor draws.

    Raises LingualError when there is no display or no OpenGL 4.1.
    """
    if not glfw.init():
        raise LingualError(
            "No window can be opened because there is no display here: use --headless to render to a file."
        )
    window = _create(title, width, height, 4 if samples is None else samples)
    if samples is None and is_software(window_context()):
        glfw.destroy_window(window)
        window = _create(title, width, height, 0)
    return window


def _create(title: str, width: int, height: int, samples: int) -> GlfwWindow:
    glfw.default_window_hints()
    glfw.window_hint(glfw.CONTEXT_VERSION_MAJOR, 4)
    glfw.window_hint(glfw.CONTEXT_VERSION_MINOR, 1)
    glfw.window_hint(glfw.OPENGL_PROFILE, glfw.OPENGL_CORE_PROFILE)
    glfw.window_hint(glfw.OPENGL_FORWARD_COMPAT, True)
    glfw.window_hint(glfw.SAMPLES, samples)
    glfw.window_hint(glfw.SCALE_TO_MONITOR, True)
    window = glfw.create_window(width, height, f"Lingual - {title}", None, None)
    if not window:
        reason = glfw.get_error()[1]
        glfw.terminate()
        text = reason.decode(errors="replace") if isinstance(reason, bytes) else reason
        raise LingualError(
            f"No window with OpenGL 4.1 can be opened ({text}): update the graphics driver, "
            "'apt-get install libgl1 libgl1-mesa-dri', or use --headless to render to a file."
        )
    glfw.make_context_current(window)
    glfw.swap_interval(1)
    return window


def content_scale(window: GlfwWindow) -> float:
    """Pixels per point that the screen asks for, where the framebuffer does not already have them."""
    if sys.platform == "darwin":
        return 1.0
    return max(float(glfw.get_window_content_scale(window)[0]), 1.0)


def refresh_rate() -> float:
    """Pictures per second that the screen shows [1/s]."""
    monitor = glfw.get_primary_monitor()
    mode = glfw.get_video_mode(monitor) if monitor else None
    return float(mode.refresh_rate) if mode and mode.refresh_rate >= 30 else 60.0
