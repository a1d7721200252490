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


def scene_bounds(model: TongueModel) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Corners of a box around the tongue and the parts near it at rest [m], (3,) each.

    Parts reach far beyond the tongue (the ramus of the mandible); the box keeps to 12 mm around it.
    """
    rest = model.skin.vertices(model.mesh.nodes)
    low, high = rest.min(axis=0), rest.max(axis=0)
    if not model.rigid:
        return low, high
    around = np.concatenate([r.vertices for r in model.rigid])
    margin = 0.012
    return np.maximum(low - margin, np.minimum(low, around.min(axis=0))), np.minimum(
        high + margin, np.maximum(high, around.max(axis=0))
    )


def default_camera(model: TongueModel, view: str = "three-quarter") -> Camera:
    """A camera that frames the tongue in its mouth from a built-in view."""
    low, high = scene_bounds(model)
    camera = framing(low, high, view)
    camera.distance *= 1.0
    return camera
