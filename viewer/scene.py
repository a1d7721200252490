"""Everything in the picture, drawn in the right order into whatever framebuffer is in use."""

from collections.abc import Iterator
from contextlib import contextmanager

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..model import TongueModel
from ..model.history import Sample
from .backdrop_layer import BackdropLayer
from .camera import Camera, framing
from .detail import FULL_DETAIL, Detail, display_surfaces
from .frame_uniforms import NO_CLIPPING, FrameUniforms, midsagittal_plane
from .gl_resources import release_all
from .rigid_layer import RigidLayer
from .sensor_layer import SensorLayer
from .session_view import ScalarField
from .tongue_layer import TongueLayer
from .view_options import ViewOptions

_GL_CLIP_DISTANCE0 = 0x3000

_AROUND = {"bone": 0.007, "tooth": 0.025, "mucosa": 0.025}  # [m]: parts this near are in the picture
_ASPECT = 4.0 / 3.0  # the narrowest picture in which the default view has everything


class Scene:
    """The tongue in its mouth on the graphics device.

    `update` once per instant, then `draw` for every view of it. `release` when done.
    """

    def __init__(self, context: moderngl.Context, model: TongueModel, detail: Detail = FULL_DETAIL) -> None:
        self._context = context
        mouth = display_surfaces(model.rigid, detail)
        self._uniforms = FrameUniforms(context)
        self._backdrop = BackdropLayer(context)
        self._tongue = TongueLayer(context, model, mouth, detail)
        self._rigid = RigidLayer(context, mouth)
        self._sensors = SensorLayer(context, model.sensors.count)
        self._sample: Sample | None = None

    def update(self, sample: Sample, scalar: ScalarField | None, options: ViewOptions) -> None:
        """Uploads one instant; `scalar` None shows the tongue's natural colours."""
        self._sample = sample
        if options.show_tongue:
            self._tongue.update(sample, scalar, cut=options.cut)
        self._sensors.update(sample, targets=options.show_targets)

    def draw(self, camera: Camera, aspect: float, options: ViewOptions) -> None:
        """Draws what was last uploaded into the current framebuffer and viewport.

        The depth buffer must have been cleared; the backdrop covers every pixel. aspect: width over height.
        """
        if self._sample is None:
            raise RuntimeError("Scene.update must come before Scene.draw")
        plane = midsagittal_plane(camera) if options.cut else NO_CLIPPING
        self._uniforms.write(camera, aspect, options.backdrop, plane)
        with self._clipping(options.cut):
            if options.show_tongue:
                self._tongue.draw(cut=options.cut)
        self._backdrop.draw()
        self._sensors.draw(options)
        with self._clipping(options.cut):
            self._rigid.draw(self._sample, camera, options)
        self._sensors.draw_through(options)

    @contextmanager
    def _clipping(self, cut: bool) -> Iterator[None]:
        if cut:
            self._context.enable_direct(_GL_CLIP_DISTANCE0)
        yield
        if cut:
            self._context.disable_direct(_GL_CLIP_DISTANCE0)

    def release(self) -> None:
        """Frees everything on the graphics device."""
        release_all(self._tongue, self._rigid, self._sensors, self._backdrop, self._uniforms)


def default_camera(model: TongueModel, view: str = "three-quarter") -> Camera:
    """A camera that frames the tongue in its mouth from a built-in view."""
    return framing(subject(model), view, _ASPECT)


def subject(model: TongueModel) -> NDArray[np.float64]:
    """Points that a picture should have in it [m], (n, 3): the tongue at rest and what is around it.

    Of the other parts counts what is near the tongue's bounding box; the mandible's rami reach far beyond.
    """
    rest = model.skin.vertices(model.mesh.nodes)
    low, high = rest.min(axis=0), rest.max(axis=0)
    points = [rest]
    for part in model.rigid:
        reach = _AROUND.get(part.tissue, _AROUND["bone"])
        near = np.all((part.vertices > low - reach) & (part.vertices < high + reach), axis=1)
        points.append(part.vertices[near])
    return np.concatenate(points)
