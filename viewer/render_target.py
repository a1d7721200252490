"""An antialiased picture in memory: multisampled drawing, resolved to bytes."""

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..model import LingualError


class RenderTarget:
    """A framebuffer of width x height pixels with `samples` coverage samples each (0: none)."""

    def __init__(self, context: moderngl.Context, width: int, height: int, samples: int = 4) -> None:
        if width < 1 or height < 1:
            raise LingualError(f"A picture of {width} x {height} pixels cannot be drawn: use 1 or more.")
        self._context = context
        self.width, self.height = width, height
        self.samples = min(samples, context.max_samples)
        size = (width, height)
        try:
            self._resolved = context.simple_framebuffer(size, 4)
            self._drawn = (
                context.framebuffer(
                    context.renderbuffer(size, 4, samples=self.samples),
                    context.depth_renderbuffer(size, samples=self.samples),
                )
                if self.samples
                else self._resolved
            )
        except moderngl.Error as error:
            raise LingualError(f"A picture of {width} x {height} pixels is too large: {error}") from error
        self._bytes = np.empty((height, width, 4), dtype=np.uint8)

    @property
    def aspect(self) -> float:
        """Width over height."""
        return self.width / self.height

    def begin(self) -> None:
        """Makes it the framebuffer that is drawn into, cleared."""
        self._drawn.use()
        self._drawn.clear(0.0, 0.0, 0.0, 0.0)

    def read(self) -> NDArray[np.uint8]:
        """The picture, (height, width, 4) RGBA with the top row first; valid until the next read."""
        if self.samples:
            self._context.copy_framebuffer(self._resolved, self._drawn)
        self._resolved.read_into(self._bytes, components=4)
        return self._bytes[::-1]

    def release(self) -> None:
        """Frees both framebuffers and what they are made of."""
        for framebuffer in {self._resolved, self._drawn}:
            attachments = (*framebuffer.color_attachments, framebuffer.depth_attachment)
            framebuffer.release()
            for attachment in attachments:
                attachment.release()
