"""Dear ImGui in the window: contexts, backends, frames."""

import ctypes
from typing import Any

from imgui_bundle import imgui, implot

from .glfw_library import glfw
from .theme import apply_theme


class Gui:
    """Owns the imgui and implot contexts of one glfw window whose GL context is current."""

    def __init__(self, window: Any, scale: float = 1.0) -> None:
        imgui.create_context()
        implot.create_context()
        imgui.get_io().set_ini_filename("")  # nothing is saved; the layout is fixed
        apply_theme(scale)
        address = int(ctypes.cast(window, ctypes.c_void_p).value or 0)
        imgui.backends.glfw_init_for_opengl(address, True)
        imgui.backends.opengl3_init("#version 410")
        flush = ctypes.cast(glfw.get_proc_address("glFlush"), ctypes.c_void_p)
        self._gl_flush = ctypes.CFUNCTYPE(None)(int(flush.value or 0))

    def flush(self) -> None:
        """Sends what has been drawn so far on its way, so that the device works while Python does."""
        self._gl_flush()

    def begin(self) -> None:
        """Starts a frame: reads the input that glfw has gathered."""
        imgui.backends.opengl3_new_frame()
        imgui.backends.glfw_new_frame()
        imgui.new_frame()

    def finish(self) -> None:
        """Ends the frame without drawing it yet."""
        imgui.render()

    def draw(self) -> None:
        """Draws the panels into the current framebuffer."""
        imgui.backends.opengl3_render_draw_data(imgui.get_draw_data())

    def release(self) -> None:
        """Ends both backends and contexts."""
        imgui.backends.opengl3_shutdown()
        imgui.backends.glfw_shutdown()
        implot.destroy_context()
        imgui.destroy_context()
