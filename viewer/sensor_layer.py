"""Coils as small spheres in distinct colours, their targets as glassy ones where they differ."""

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..model.history import Sample
from .gl_resources import release_all
from .shader_program import load_program, set_uniform
from .view_options import ViewOptions

SENSOR_COLOURS = ("f0e442", "e69f00", "00b38a", "56b4e9", "cc79a7", "ffffff")
"""sRGB, after Okabe and Ito (2008): distinct to colour-blind eyes; repeats when there are more coils."""

_RADIUS = 0.0016
_TARGET_RADIUS = 0.0022
_TARGET_DISTANCE = 0.0005  # [m]: a target nearer to its coil than this is not drawn
_THROUGH_TISSUE = 0.4  # opacity of a coil behind tissue


def sensor_colour(index: int) -> tuple[float, float, float]:
    """Display colour of a coil, sRGB in [0, 1]."""
    text = SENSOR_COLOURS[index % len(SENSOR_COLOURS)]
    return tuple(int(text[i : i + 2], 16) / 255.0 for i in (0, 2, 4))  # type: ignore[return-value]


class SensorLayer:
    """Draws coils and targets as instances of one sphere."""

    def __init__(self, context: moderngl.Context, sensor_count: int) -> None:
        self._context = context
        self._program = load_program(context, "sensor", "sensor")
        vertices, triangles = unit_sphere()
        self._colours = np.array([sensor_colour(i) for i in range(sensor_count)]).reshape(-1, 3)
        self._instances = np.zeros((2 * sensor_count, 8), dtype=np.float32)
        self._count = sensor_count
        self._sphere = context.buffer(vertices.astype("f4").tobytes())
        self._triangles = context.buffer(triangles.astype("i4").tobytes())
        self._buffer = context.buffer(reserve=max(self._instances.nbytes, 32), dynamic=True)
        layout = [
            (self._sphere, "3f", "in_vertex"),
            (self._buffer, "4f 4f/i", "in_sphere", "in_colour"),
        ]
        self._mesh = context.vertex_array(self._program, layout, index_buffer=self._triangles)

    def update(self, sample: Sample, *, targets: bool) -> None:
        """Uploads where coils and, if wanted, their targets are."""
        away = np.linalg.norm(sample.sensor_targets - sample.sensors, axis=1) > _TARGET_DISTANCE
        rows = self._instances
        n = self._count
        rows[:n, :3] = sample.sensors + sample.jaw_translation
        rows[:n, 3], rows[:n, 4:7], rows[:n, 7] = _RADIUS, self._colours, 1.0
        rows[n:, :3] = np.nan_to_num(sample.sensor_targets) + sample.jaw_translation
        rows[n:, 3] = np.where(away & targets, _TARGET_RADIUS, 0.0)
        rows[n:, 4:7], rows[n:, 7] = self._colours, 0.25
        self._buffer.write(rows)

    def draw(self, options: ViewOptions) -> None:
        """Draws coils and targets where opaque tissue does not hide them."""
        if options.show_sensors and self._count:
            self._context.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE | moderngl.BLEND)
            self._render(2 * self._count, 1.0)

    def draw_through(self, options: ViewOptions) -> None:
        """Draws the coils faintly over everything, so that none is lost behind teeth or tongue."""
        if options.show_sensors and self._count:
            self._context.enable_only(moderngl.CULL_FACE | moderngl.BLEND)
            self._render(self._count, _THROUGH_TISSUE)

    def _render(self, instances: int, strength: float) -> None:
        self._context.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
        set_uniform(self._program, "strength", strength)
        self._mesh.render(instances=instances)

    def release(self) -> None:
        """Frees everything on the graphics device."""
        release_all(self._mesh, self._sphere, self._triangles, self._buffer, self._program)


def unit_sphere(stacks: int = 12, slices: int = 20) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """A sphere of radius 1: vertices (n, 3) and outward triangles (m, 3)."""
    polar, turn = np.meshgrid(
        np.linspace(0.0, np.pi, stacks + 1), np.linspace(0.0, 2.0 * np.pi, slices + 1), indexing="ij"
    )
    vertices = np.stack([np.sin(polar) * np.cos(turn), np.sin(polar) * np.sin(turn), np.cos(polar)], axis=-1)
    corner = (np.arange(stacks)[:, None] * (slices + 1) + np.arange(slices)).ravel()
    below = corner + slices + 1
    triangles = np.concatenate(
        [np.stack([corner, below, below + 1], axis=1), np.stack([corner, below + 1, corner + 1], axis=1)]
    )
    return vertices.reshape(-1, 3), triangles.astype(np.int32)
