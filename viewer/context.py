"""OpenGL contexts: headless through EGL, or of the window that is current."""

import sys
from typing import Any

import moderngl

from ..model import LingualError

REQUIRED_VERSION = 410
"""Core profile 4.1: the newest that macOS has."""

_SOFTWARE_RENDERERS = ("llvmpipe", "softpipe", "swrast", "software")


def headless_context() -> moderngl.Context:
    """A context without window or display, current on this thread.

    Raises LingualError when EGL is missing or the driver is older than OpenGL 4.1.
    """
    arguments: dict[str, Any] = {"standalone": True, "require": REQUIRED_VERSION}
    if sys.platform.startswith("linux"):
        # glvnd's libEGL resolves OpenGL functions itself, so that libGL (GLX) need not be installed.
        arguments |= {"backend": "egl", "libegl": "libEGL.so.1", "libgl": "libEGL.so.1"}
    try:
        return moderngl.create_context(**arguments)
    except Exception as error:  # moderngl raises bare Exception
        raise LingualError(_headless_message(error)) from error


def _headless_message(error: Exception) -> str:
    text = str(error)
    if "not loaded" in text or "not found" in text or "eglInitialize" in text or "eglQueryDevices" in text:
        return (
            f"Pictures cannot be drawn without a display because EGL is missing ({text}): "
            "install it with 'apt-get install libegl1 libgl1-mesa-dri'."
        )
    return (
        f"This machine's graphics driver does not offer OpenGL 4.1 ({text}): update it, or install Mesa's "
        "software driver with 'apt-get install libegl1 libgl1-mesa-dri'."
    )


def window_context() -> moderngl.Context:
    """moderngl's view of the window context that is current on this thread.

    Raises LingualError when the driver is older than OpenGL 4.1.
    """
    try:
        return moderngl.create_context(require=REQUIRED_VERSION)
    except Exception as error:
        raise LingualError(
            f"This machine's graphics driver does not offer OpenGL 4.1 ({error}): update it, or use --headless."
        ) from error


def renderer_name(context: moderngl.Context) -> str:
    """The driver's name of the device that draws, e.g. "llvmpipe (LLVM 15.0.6, 256 bits)"."""
    return str(context.info.get("GL_RENDERER", "unknown"))


def is_software(context: moderngl.Context) -> bool:
    """Whether the processor draws (Mesa llvmpipe and the like) and fragment work must be spared."""
    name = renderer_name(context).lower()
    return any(word in name for word in _SOFTWARE_RENDERERS)
