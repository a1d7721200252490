"""Jaw, teeth, palate and hyoid: rigid, translucent, blended back to front.

All parts share one mesh whose triangles are put in order of their distance to the eye whenever the eye
or the jaw has moved: one draw call, right through every layer, also where parts lie inside each other.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..model.history import Sample
from .ambient_occlusion import Occluder, ambient_occlusion
from .camera import Camera
from .detail import DisplaySurface
from .gl_resources import release_all
from .shader_program import load_program, set_uniform
from .view_options import ViewOptions


@dataclass(frozen=True)
class Tissue:
    """Look of a rigid tissue.

    reflectance: diffuse, linear RGB. opacity: facing the eye and at grazing view. gloss: of highlights.
    """

    reflectance: tuple[float, float, float]
    opacity: tuple[float, float]
    gloss: float


TISSUES = {
    "bone": Tissue((0.70, 0.76, 0.82), (0.13, 0.72), 0.35),
    "tooth": Tissue((0.68, 0.605, 0.465), (0.88, 0.98), 0.5),
    "mucosa": Tissue((0.70, 0.27, 0.26), (0.17, 0.62), 0.14),
}
"""Looks by RigidSurface.tissue; an unknown tissue looks like bone."""

_DEPTH_SLABS = 4096  # triangles whose distances fall into one slab keep their order in memory
_JAW_STEP = 2e-4  # [m]: motion of the jaw that is worth a new order


class RigidLayer:
    """Draws the mouth around the tongue."""

    def __init__(self, context: moderngl.Context, surfaces: tuple[DisplaySurface, ...]) -> None:
        self._context = context
        self._surfaces = surfaces
        self._program = load_program(context, "rigid", "rigid")
        triangles, part = _merged_triangles(surfaces)
        self._triangles, self._part = triangles, part
        self._in_jaw = np.array([s.frame == "jaw" for s in surfaces], dtype=bool)
        data = _vertex_data(context, surfaces)
        corners = data[triangles, :3]
        self._centres = corners.mean(axis=1)
        self._facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self._vertices = context.buffer(data.tobytes()) if len(data) else None
        self._order = context.buffer(reserve=max(triangles.nbytes, 12), dynamic=True)
        self._ordered_for: tuple | None = None
        self._ordered_count = 0
        self._mesh: moderngl.VertexArray | None = None
        if self._vertices is not None:
            layout = [(self._vertices, "3f 3f 3f", "in_position", "in_normal", "in_kind")]
            self._mesh = context.vertex_array(self._program, layout, index_buffer=self._order)

    def draw(self, sample: Sample, camera: Camera, options: ViewOptions) -> None:
        """Blends the visible parts over what is already drawn, without writing depth."""
        shown = np.array([options.show_tissue.get(s.tissue, True) for s in self._surfaces], dtype=bool)
        if self._mesh is None or not shown.any():
            return
        self._sort(camera.eye, sample.jaw_translation, shown, both_sides=options.cut)
        program, context = self._program, self._context
        looks, factor = list(TISSUES.values()), options.opacity
        set_uniform(program, "jaw_translation", tuple(sample.jaw_translation))
        set_uniform(program, "reflectance", [look.reflectance for look in looks])
        set_uniform(program, "surface", [(*(min(factor * a, 1.0) for a in t.opacity), t.gloss) for t in looks])
        flags = moderngl.DEPTH_TEST | moderngl.BLEND
        context.enable_only(flags)
        context.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
        context.fbo.depth_mask = False
        self._mesh.render(vertices=self._ordered_count)
        context.fbo.depth_mask = True

    def _sort(
        self,
        eye: NDArray[np.float64],
        jaw: NDArray[np.float64],
        shown: NDArray[np.bool_],
        *,
        both_sides: bool,
    ) -> None:
        """Orders the shown triangles from far to near, unless they already are.

        Those that face away are left out, which spares the vertex stage, unless `both_sides` are wanted.
        """
        wanted = (tuple(eye), tuple(np.round(jaw / _JAW_STEP)), tuple(shown), both_sides)
        if wanted == self._ordered_for:
            return
        moved = np.where(self._in_jaw[:, None], jaw, 0.0).astype(np.float32)
        away = self._centres + (moved - eye.astype(np.float32))[self._part]
        distance = np.einsum("ij,ij->i", away, away)
        near, far = float(distance.min()), float(distance.max())
        slab = ((far - distance) * np.float32((_DEPTH_SLABS - 1) / max(far - near, 1e-12))).astype(np.uint16)
        order = np.argsort(slab, kind="stable")  # radix sort
        drawn = shown[self._part]
        if not both_sides:
            drawn &= np.einsum("ij,ij->i", away, self._facing) < 0.0
        order = order[drawn[order]]
        self._ordered_count = 3 * len(order)
        self._order.orphan()
        self._order.write(self._triangles[order])
        self._ordered_for = wanted

    def release(self) -> None:
        """Frees everything on the graphics device."""
        release_all(self._mesh, self._vertices, self._order, self._program)


def _vertex_data(context: moderngl.Context, surfaces: Iterable[DisplaySurface]) -> NDArray[np.float32]:
    """Position, normal and (occlusion, index into TISSUES, 1 if in the jaw frame), (vertex_count, 9)."""
    kinds = {name: i for i, name in enumerate(TISSUES)}
    rows = [np.zeros((0, 9))]
    for surface in surfaces:
        itself = (Occluder(surface.vertices, surface.triangles),)
        kind = np.empty((len(surface.vertices), 3))
        kind[:, 0] = ambient_occlusion(context, surface.vertices, surface.normals, itself)
        kind[:, 1] = kinds.get(surface.tissue, 0)
        kind[:, 2] = surface.frame == "jaw"
        rows.append(np.hstack([surface.vertices, surface.normals, kind]))
    return np.concatenate(rows).astype(np.float32)


def _merged_triangles(surfaces: Iterable[DisplaySurface]) -> tuple[NDArray[np.int32], NDArray[np.int64]]:
    """Triangles of all surfaces over their joined vertices, (n, 3), and the surface of each, (n,).

    Triangles that face away are not drawn, so an open surface gets both sides.
    """
    triangles, part, start = [np.zeros((0, 3), np.int32)], [np.zeros(0, np.int64)], 0
    for index, surface in enumerate(surfaces):
        t = surface.triangles.astype(np.int32) + np.int32(start)
        if not is_closed(surface.triangles):
            t = np.concatenate([t, t[:, ::-1]])
        triangles.append(t)
        part.append(np.full(len(t), index))
        start += len(surface.vertices)
    return np.concatenate(triangles), np.concatenate(part)


def is_closed(triangles: NDArray[np.integer]) -> bool:
    """Whether nearly every edge has a neighbour on its other side (a few cracks do not open a surface)."""
    edges = np.sort(triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    counts = np.unique(edges, axis=0, return_counts=True)[1]
    return bool(np.mean(counts == 1) < 0.005)
