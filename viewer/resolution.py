"""Drawing the scene in fewer pixels than the window has, where a processor draws and falls behind."""

import moderngl
import numpy as np

from .gl_resources import release_all
from .shader_program import load_program

SCALES = (1.0, 0.85, 0.7, 0.55)
"""Pixels drawn per pixel shown, along one side."""
_PATIENCE = 24  # pictures between two decisions
_BUSY, _IDLE = 0.75, 0.35  # share of the period that a picture's work may take before the scale changes


class AdaptiveScale:
    """Chooses the scale from the work of the last pictures. period: time between pictures [s]."""

    def __init__(self, period: float) -> None:
        self._period = period
        self._work: list[float] = []
        self._step = 0

    @property
    def scale(self) -> float:
        return SCALES[self._step]

    def add(self, work: float) -> None:
        """Takes the work of one picture [s]."""
        self._work.append(work)
        if len(self._work) < _PATIENCE:
            return
        share = float(np.median(self._work)) / self._period
        self._work.clear()
        if share > _BUSY:
            self._step = min(self._step + 1, len(SCALES) - 1)
        elif share < _IDLE:
            self._step = max(self._step - 1, 0)


class ScaledPicture:
    """A framebuffer of changing size and what spreads it over a larger viewport."""

    def __init__(self, context: moderngl.Context) -> None:
        self._context = context
        self._program = load_program(context, "backdrop", "upscale")
        self._triangle = context.vertex_array(self._program, [])
        self._framebuffer: moderngl.Framebuffer | None = None

    def begin(self, width: int, height: int) -> None:
        """Makes a cleared picture of width x height pixels the one that is drawn into."""
        if self._framebuffer is None or self._framebuffer.size != (width, height):
            self._release_picture()
            colour = self._context.texture((width, height), 4)
            colour.repeat_x = colour.repeat_y = False
            self._colour = colour
            self._framebuffer = self._context.framebuffer(colour, self._context.depth_renderbuffer((width, height)))
        self._framebuffer.use()
        self._framebuffer.clear(0.0, 0.0, 0.0, 1.0, depth=1.0)

    def show(self) -> None:
        """Spreads the picture over the viewport of the framebuffer in use."""
        if self._framebuffer is None:
            raise RuntimeError("ScaledPicture.begin must come before show")
        self._context.enable_only(moderngl.NOTHING)
        self._colour.use(0)
        self._program["picture"] = 0
        self._triangle.render(moderngl.TRIANGLES, vertices=3)

    def _release_picture(self) -> None:
        if self._framebuffer is not None:
            release_all(self._framebuffer, self._colour, self._framebuffer.depth_attachment)
            self._framebuffer = None

    def release(self) -> None:
        """Frees everything on the graphics device."""
        self._release_picture()
        release_all(self._triangle, self._program)
