"""The one GLFW of the process.

imgui-bundle carries a GLFW library that its backend is linked with, and points pyGLFW to it when
imported first; two copies would not know each other's windows. So import glfw from here.
"""

import imgui_bundle  # noqa: F401  isort: skip
import glfw

glfw.ERROR_REPORTING = "ignore"  # errors are asked for with glfw.get_error() where they matter

__all__ = ["glfw"]
