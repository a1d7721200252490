"""The studio's backdrop behind everything."""

import moderngl

from .gl_resources import release_all
from .shader_program import load_program


class BackdropLayer:
    """Fills every pixel that nothing has covered yet."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._program = load_program(context, "backdrop", "backdrop")
        self._triangle = context.vertex_array(self._program, [])

    def draw(self) -> None:
        """Draws at the far plane, after what is opaque, so that hidden pixels cost nothing."""
        self._context.enable_only(moderngl.DEPTH_TEST)
        self._context.depth_func = "<="
        self._triangle.render(moderngl.TRIANGLES, vertices=3)
        self._context.depth_func = "<"

    def release(self) -> None:
        """Frees everything on the graphics device."""
        release_all(self._triangle, self._program)
