"""How much of the surroundings each vertex sees, baked once at rest.

Parallel depth maps are drawn from directions all around; a vertex sees the light of a direction when
nothing in that map lies nearer. The visible share, weighted by the cosine, is its ambient occlusion.
"""

from dataclasses import dataclass

import moderngl
import numpy as np
from numpy.typing import NDArray

from .gl_resources import release_all
from .shader_program import load_program, set_uniform

_MAP_SIZE = 160
_DIRECTIONS = 56
_BIAS = 0.0012  # [m], about the size of a triangle: a surface does not shade itself


@dataclass(frozen=True, eq=False)
class Occluder:
    """A surface that takes light away.

    vertices: (vertex_count, 3) [m], head frame at rest; triangles: (triangle_count, 3).
    strength: share of the light that it takes, 1 for opaque.
    """

    vertices: NDArray[np.floating]
    triangles: NDArray[np.integer]
    strength: float = 1.0


def ambient_occlusion(
    context: moderngl.Context,
    vertices: NDArray[np.floating],
    normals: NDArray[np.floating],
    occluders: tuple[Occluder, ...],
) -> NDArray[np.float32]:
    """Share of the surroundings seen by each vertex, (vertex_count,) in [0, 1].

    vertices: (vertex_count, 3) [m], head frame at rest; normals: (vertex_count, 3), unit.
    """
    everything = np.concatenate([o.vertices for o in occluders] + [vertices])
    low, high = everything.min(axis=0), everything.max(axis=0)
    centre, radius = 0.5 * (low + high), 0.5 * float(np.linalg.norm(high - low)) + 1e-6
    seen = np.zeros(len(vertices))
    weight = np.zeros(len(vertices))
    context.enable_only(moderngl.DEPTH_TEST)
    maps = _DepthMaps(context, occluders)
    for direction in _sphere_directions(_DIRECTIONS):
        cosine = np.clip(normals @ direction, 0.0, None)
        transform = _parallel_projection(direction, centre, radius)
        seen += cosine * maps.visibility(vertices, transform, _BIAS / radius)
        weight += cosine
    maps.release()
    return (seen / np.maximum(weight, 1e-9)).astype(np.float32)


class _DepthMaps:
    """Draws the occluders' depth from one direction after the other and looks vertices up in it."""

    def __init__(self, context: moderngl.Context, occluders: tuple[Occluder, ...]) -> None:
        self._program = load_program(context, "depth", "depth")
        self._depth = context.depth_texture((_MAP_SIZE, _MAP_SIZE))
        self._target = context.framebuffer(depth_attachment=self._depth)
        self._strengths = [o.strength for o in occluders]
        self._buffers = [
            tuple(context.buffer(a.tobytes()) for a in (o.vertices.astype("f4"), o.triangles.astype("i4")))
            for o in occluders
        ]
        self._meshes = [
            context.vertex_array(self._program, [(v, "3f", "in_position")], index_buffer=t) for v, t in self._buffers
        ]

    def visibility(
        self, vertices: NDArray[np.floating], transform: NDArray[np.float64], bias: float
    ) -> NDArray[np.float64]:
        """Share of this direction's light that reaches each vertex, (vertex_count,)."""
        at = 0.5 + 0.5 * (vertices @ transform[:3, :3].T + transform[:3, 3])
        column, row = np.clip((at[:, :2] * _MAP_SIZE).astype(int), 0, _MAP_SIZE - 1).T
        set_uniform(self._program, "transform", tuple(transform.T.ravel()))
        share = np.ones(len(vertices))
        for mesh, strength in zip(self._meshes, self._strengths, strict=True):
            self._target.clear(depth=1.0)
            self._target.use()
            mesh.render()
            depth = np.frombuffer(self._depth.read(), dtype="f4").reshape(_MAP_SIZE, _MAP_SIZE)
            share *= np.where(at[:, 2] > depth[row, column] + 0.5 * bias, 1.0 - strength, 1.0)
        return share

    def release(self) -> None:
        buffers = (buffer for pair in self._buffers for buffer in pair)
        release_all(*self._meshes, *buffers, self._target, self._depth, self._program)


def _sphere_directions(count: int) -> NDArray[np.float64]:
    """Unit vectors spread evenly over the sphere (Fibonacci lattice), (count, 3)."""
    i = np.arange(count) + 0.5
    z, turn = 1.0 - 2.0 * i / count, np.pi * (1.0 + 5.0**0.5) * i
    r = np.sqrt(1.0 - z * z)
    return np.stack([r * np.cos(turn), r * np.sin(turn), z], axis=1)


def _parallel_projection(
    direction: NDArray[np.float64], centre: NDArray[np.float64], radius: float
) -> NDArray[np.float64]:
    """Head frame to clip space as seen from `direction`, (4, 4): nearer means smaller depth."""
    helper = np.eye(3)[np.argmin(np.abs(direction))]
    right = np.cross(helper, direction)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3, :3] = np.stack([right, np.cross(direction, right), -direction]) / radius
    matrix[:3, 3] = -matrix[:3, :3] @ centre
    return matrix
