"""Pictures without a window: the same scene, drawn through EGL into memory."""

from contextlib import AbstractContextManager, nullcontext
from dataclasses import replace
from types import TracebackType

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..model.history import Sample
from .camera import Camera
from .context import headless_context
from .labels import label_corners
from .overlay import INK, colour_bar_sprite, paste, text_sprite
from .render_target import RenderTarget
from .scene import Scene, default_camera
from .session_view import NO_FIELD, ScalarField, SessionView, sample_at
from .view_options import ViewOptions


class OffscreenRenderer:
    """Renders a session at any time, from any side. A context manager; `release` frees what it holds.

    width, height [pixels]. samples: multisampling per pixel (0 for none). context: an OpenGL context to
    share; None makes a headless one.

    Raises LingualError when there is no EGL or OpenGL 4.1, or the size cannot be drawn.
    """

    def __init__(
        self,
        session: SessionView,
        width: int = 1280,
        height: int = 720,
        *,
        samples: int = 4,
        context: moderngl.Context | None = None,
    ) -> None:
        self.session = session
        self._owns_context = context is None
        self._context = headless_context() if context is None else context
        with self._current():
            self._target = RenderTarget(self._context, width, height, samples)
            self._scene = Scene(self._context, session.model)

    def _current(self) -> AbstractContextManager[object]:
        """Makes its own context the current one for a while: several renderers may exist."""
        return self._context if self._owns_context else nullcontext()

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the pictures [pixels]."""
        return self._target.width, self._target.height

    def render(
        self,
        time: float,
        *,
        camera: Camera | None = None,
        field: str | None = None,
        options: ViewOptions | None = None,
    ) -> NDArray[np.uint8]:
        """The picture at `time` [s], (height, width, 4) RGBA, sRGB, top row first.

        camera: None frames the tongue in three-quarter view. field: name of the scalar on the tongue;
        None takes it from `options`. With the backdrop "transparent", colour is premultiplied by alpha.
        The array is the renderer's own and is overwritten by the next picture.
        """
        options = options or ViewOptions()
        if field is not None:
            options = replace(options, field_name=field)
        camera = camera or default_camera(self.session.model)
        sample = sample_at(self.session, time)
        scalar = None if options.field_name == NO_FIELD else self.session.field(options.field_name, sample)
        with self._current():
            self._scene.update(sample, scalar, options)
            self._target.begin()
            self._scene.draw(camera, self._target.aspect, options)
            picture = self._target.read()
        self._annotate(picture, sample, scalar, camera, options)
        return picture

    def _annotate(
        self,
        picture: NDArray[np.uint8],
        sample: Sample,
        scalar: ScalarField | None,
        camera: Camera,
        options: ViewOptions,
    ) -> None:
        """Writes names, colour bar and caption over the picture."""
        width, height = self.size
        ink = INK[options.backdrop]
        unit = max(height / 720.0, 0.5)
        if options.show_sensors and options.show_labels:
            at = camera.project(sample.sensors + sample.jaw_translation, width, height)[:, :2]
            names = self.session.model.sensors.names
            sprites = [text_sprite(name, 15 * unit, INK["dark"], plate=True) for name in names]
            sizes = np.array([sprite.shape[1::-1] for sprite in sprites]).reshape(-1, 2)
            for sprite, (x, y) in zip(sprites, label_corners(at, sizes, 10 * unit), strict=True):
                if np.isfinite(x) and np.isfinite(y):
                    paste(picture, sprite, round(x), round(y))
        if scalar is not None and options.show_colour_bar:
            sprite = colour_bar_sprite(scalar, height, ink)
            paste(picture, sprite, width - sprite.shape[1] - round(26 * unit), round(26 * unit))
        if options.show_caption:
            sprite = text_sprite(f"{self.session.title}   {sample.time:5.2f} s", 17 * unit, ink)
            paste(picture, sprite, round(26 * unit), height - sprite.shape[0] - round(20 * unit))

    def release(self) -> None:
        """Frees everything on the graphics device."""
        with self._current():
            self._scene.release()
            self._target.release()
        if self._owns_context:
            self._context.release()

    def __enter__(self) -> "OffscreenRenderer":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.release()
