"""Jaw, teeth, palate and hyoid: rigid, opaque or translucent.

All parts share one mesh, drawn in three runs. First what is opaque: teeth. Then what is blended layer by
layer: mucosa, whose triangles are put in order of their distance to the eye whenever the eye or the jaw
has moved, also where parts lie inside each other. Last the veil: bone, of which only the nearest layer is
seen. A mandible seen through itself is clutter: slivers of the inside of the chin would shine in front of
the tongue.
"""

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..model.history import Sample
from .camera import Camera
from .detail import DisplaySurface
from .gl_resources import release_all
from .rigid_mesh import VERTEX_LAYOUT, merged_triangles, vertex_data
from .shader_program import load_program, set_uniform
from .tissues import TISSUES, Opacity, Tissue, tissue_index
from .view_options import ViewOptions

_DEPTH_SLABS = 4096  # triangles whose distances fall into one slab keep their order in memory
_OPAQUE, _LAYERED, _VEIL = range(3)
_JAW_STEP = 2e-4  # [m]: motion of the jaw that is worth a new order


class RigidLayer:
    """Draws the mouth around the tongue."""

    def __init__(self, context: moderngl.Context, surfaces: tuple[DisplaySurface, ...]) -> None:
        self._context = context
        self._surfaces = surfaces
        self._program = load_program(context, "rigid", "rigid")
        triangles, part = merged_triangles(surfaces)
        self._triangles, self._part = triangles, part
        self._in_jaw = np.array([s.frame == "jaw" for s in surfaces], dtype=bool)
        self._tissue = np.array([tissue_index(s.tissue) for s in surfaces], dtype=int)
        data = vertex_data(context, surfaces)
        corners = data[triangles, :3]
        self._centres = corners.mean(axis=1)
        self._facing = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        self._vertices = context.buffer(data.tobytes()) if len(data) else None
        self._order = context.buffer(reserve=max(triangles.nbytes, 12), dynamic=True)
        self._ordered_for: tuple | None = None
        self._counts = (0, 0, 0)  # indices of what is opaque, layered, veil
        self._depth_program = load_program(context, "rigid_depth", "depth")
        self._mesh: moderngl.VertexArray | None = None
        self._depth_mesh: moderngl.VertexArray | None = None
        if self._vertices is not None:
            layout = [(self._vertices, *VERTEX_LAYOUT)]
            self._mesh = context.vertex_array(self._program, layout, index_buffer=self._order)
            self._depth_mesh = context.vertex_array(
                self._depth_program, layout, index_buffer=self._order, skip_errors=True
            )

    def draw(self, sample: Sample, camera: Camera, options: ViewOptions) -> None:
        """Draws the visible parts over what is already drawn."""
        shown = np.array([options.show_tissue.get(s.tissue, True) for s in self._surfaces], dtype=bool)
        if self._mesh is None or self._depth_mesh is None or not shown.any():
            return
        looks, factor = list(TISSUES.values()), options.opacity
        runs = np.array([_run(look, factor) for look in looks])[self._tissue]
        self._sort(camera.eye, sample.jaw_translation, shown, runs, both_sides=options.cut)
        program, context = self._program, self._context
        for each in (program, self._depth_program):
            set_uniform(each, "jaw_translation", tuple(sample.jaw_translation))
        set_uniform(program, "reflectance", [look.reflectance for look in looks])
        set_uniform(program, "surface", [(*_scaled(look.opacity, factor), look.gloss) for look in looks])
        set_uniform(program, "at_teeth", [_scaled(look.at_teeth, factor) for look in looks])
        context.enable_only(moderngl.DEPTH_TEST | moderngl.BLEND)  # edges of what is opaque fade out, too
        context.blend_func = moderngl.ONE, moderngl.ONE_MINUS_SRC_ALPHA
        opaque, layered, veil = self._counts
        if opaque:
            self._mesh.render(vertices=opaque)
        if layered:
            context.fbo.depth_mask = False
            self._mesh.render(vertices=layered, first=opaque)
            context.fbo.depth_mask = True
        if veil:
            context.fbo.color_mask = False, False, False, False
            context.fbo.use()  # the mask counts from here on
            self._depth_mesh.render(vertices=layered + veil, first=opaque)
            context.fbo.color_mask = True, True, True, True
            context.fbo.use()
            context.depth_func = "<="
            self._mesh.render(vertices=veil, first=opaque + layered)
            context.depth_func = "<"

    def _sort(
        self,
        eye: NDArray[np.float64],
        jaw: NDArray[np.float64],
        shown: NDArray[np.bool_],
        runs: NDArray[np.int64],
        *,
        both_sides: bool,
    ) -> None:
        """Puts the shown triangles in the order of their runs, the layered ones from far to near, if they are not.

        shown, runs: (part_count,). Triangles that face away are left out, which spares the vertex stage,
        unless `both_sides` are wanted.
        """
        wanted = (tuple(eye), tuple(np.round(jaw / _JAW_STEP)), tuple(shown), tuple(runs), both_sides)
        if wanted == self._ordered_for:
            return
        moved = np.where(self._in_jaw[:, None], jaw, 0.0).astype(np.float32)
        away = self._centres + (moved - eye.astype(np.float32))[self._part]
        drawn = shown[self._part]
        if not both_sides:
            drawn &= np.einsum("ij,ij->i", away, self._facing) < 0.0
        run = runs[self._part]
        opaque, layered, veil = (np.flatnonzero(drawn & (run == r)) for r in (_OPAQUE, _LAYERED, _VEIL))
        order = np.concatenate([opaque, layered[_far_to_near(away[layered])], veil])
        self._counts = 3 * len(opaque), 3 * len(layered), 3 * len(veil)
        self._order.orphan()
        self._order.write(self._triangles[order])
        self._ordered_for = wanted

    def release(self) -> None:
        """Frees everything on the graphics device."""
        release_all(self._mesh, self._depth_mesh, self._vertices, self._order)
        release_all(self._program, self._depth_program)


def _run(look: Tissue, factor: float) -> int:
    """In which run a tissue is drawn when its opacity is multiplied by `factor`."""
    if factor * min(look.opacity) >= 1.0:
        return _OPAQUE
    return _VEIL if look.veil else _LAYERED


def _far_to_near(away: NDArray[np.float32]) -> NDArray[np.int64]:
    """Order of points given relative to the eye, (n, 3)."""
    distance = np.einsum("ij,ij->i", away, away)
    near, far = float(distance.min(initial=np.inf)), float(distance.max(initial=0.0))
    slab = ((far - distance) * np.float32((_DEPTH_SLABS - 1) / max(far - near, 1e-12))).astype(np.uint16)
    return np.argsort(slab, kind="stable")  # radix sort


def _scaled(opacity: Opacity, factor: float) -> Opacity:
    facing, grazing = opacity
    return min(factor * facing, 1.0), min(factor * grazing, 1.0)
