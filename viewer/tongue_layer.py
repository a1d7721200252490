"""The tongue: its skin, updated every picture, with its natural look or a scalar in colour."""

import moderngl
import numpy as np
from numpy.typing import NDArray

from ..model import TongueModel
from ..model.history import Sample
from .ambient_occlusion import Occluder, ambient_occlusion
from .closeness import closeness
from .colour_map import colour_table
from .detail import Detail, DisplaySurface, display_skin
from .gl_resources import release_all
from .papillae import TILE, papillae_texture
from .section_layer import SectionLayer
from .session_view import ScalarField
from .shader_program import load_program, set_uniform

_CLOSENESS_UNIT = 3
_PALATE_SHADE = 0.35  # share of ambient light that the translucent mouth takes from the tongue


class TongueLayer:
    """Draws the skin; no graphics memory is allocated after construction.

    mouth: the rigid parts around, which shade the tongue a little.
    """

    def __init__(
        self, context: moderngl.Context, model: TongueModel, mouth: tuple[DisplaySurface, ...], detail: Detail
    ) -> None:
        self._context = context
        self._skin = skin = display_skin(model.skin, model.mesh.nodes, detail)
        rest = skin.vertices(model.mesh.nodes)
        normals = skin.normals(rest)
        shades = tuple(Occluder(part.vertices, part.triangles, _PALATE_SHADE) for part in mouth)
        itself = Occluder(rest, skin.triangles)
        tissue = tissue_variation(rest, normals)
        tissue[:, 0] = ambient_occlusion(context, rest, normals, (itself, *shades))

        self._vertices = np.empty((len(rest), 6), dtype=np.float32)
        self._moving = context.buffer(reserve=self._vertices.nbytes, dynamic=True)
        self._scalar = context.buffer(np.zeros(len(rest), dtype="f4").tobytes(), dynamic=True)
        self._fixed = context.buffer(np.hstack([rest, tissue]).astype("f4").tobytes())
        self._triangles = context.buffer(skin.triangles.astype("i4").tobytes())
        self._papillae = papillae_texture(context)
        around = closeness(rest, mouth)
        self._closeness = around.texture(context)
        self._closeness_box = tuple(around.low), tuple(1.0 / (around.high - around.low))
        self._maps = {name: _colour_map_texture(context, name) for name in ("viridis", "diverging", "categories")}
        self._map = self._maps["viridis"]
        self._nearest_node = skin.weights.argmax(axis=1)  # whose category a vertex takes
        self._field_shown = self._categories_shown = False
        self._jaw_translation = np.zeros(3)
        self._skin_program = load_program(context, "tongue", "tongue")
        self._cut_program = load_program(context, "tongue", "cut")
        self._section = SectionLayer(context, model.mesh)
        self._skin_mesh = self._mesh(self._skin_program)
        self._cut_mesh = self._mesh(self._cut_program)

    def _mesh(self, program: moderngl.Program) -> moderngl.VertexArray:
        content = [
            (self._moving, "3f 3f", "in_position", "in_normal"),
            (self._fixed, "3f 4f", "in_rest", "in_tissue"),
            (self._scalar, "1f", "in_scalar"),
        ]
        return self._context.vertex_array(program, content, index_buffer=self._triangles, skip_errors=True)

    def update(self, sample: Sample, scalar: ScalarField | None, *, cut: bool) -> None:
        """Uploads the skin at `sample` and, if given, the scalar on it (and, if cut, inside it)."""
        vertices = self._skin.vertices(sample.nodes)
        self._vertices[:, :3] = vertices
        self._vertices[:, 3:] = self._skin.normals(vertices)
        self._moving.orphan()
        self._moving.write(self._vertices)
        self._jaw_translation = sample.jaw_translation
        self._field_shown = False
        if scalar is not None:
            self._scalar.orphan()
            fraction = scalar.fraction()
            on_skin = fraction[self._nearest_node] if scalar.categories else self._skin.weights @ fraction
            self._scalar.write(np.asarray(on_skin, dtype=np.float32))
            self._map = self._maps[scalar.map_name]
            self._categories_shown = bool(scalar.categories)
            self._field_shown = True
            if cut:
                self._section.update(sample, scalar)

    def draw(self, *, cut: bool) -> None:
        """Draws the skin and, where the clipping plane opens it, the inside."""
        context = self._context
        context.enable_only(moderngl.DEPTH_TEST | moderngl.CULL_FACE)
        self._papillae.use(0)
        self._map.use(1)
        self._closeness.use(_CLOSENESS_UNIT)
        for program in (self._skin_program, self._cut_program):
            set_uniform(program, "jaw_translation", tuple(self._jaw_translation))
            set_uniform(program, "closeness", _CLOSENESS_UNIT)
            set_uniform(program, "closeness_low", self._closeness_box[0])
            set_uniform(program, "closeness_scale", self._closeness_box[1])
        set_uniform(self._skin_program, "papillae", 0)
        set_uniform(self._skin_program, "colour_map", 1)
        set_uniform(self._skin_program, "papillae_per_metre", 1.0 / TILE)
        set_uniform(self._skin_program, "field_shown", self._field_shown)
        set_uniform(self._skin_program, "categories_shown", self._categories_shown)
        self._skin_mesh.render()
        if cut:
            context.cull_face = "front"
            self._cut_mesh.render()
            context.cull_face = "back"
            if self._field_shown:
                self._section.draw(self._map)

    def release(self) -> None:
        """Frees everything on the graphics device."""
        release_all(self._skin_mesh, self._cut_mesh, self._section, *self._maps.values(), self._papillae)
        release_all(self._closeness, self._moving, self._scalar, self._fixed, self._triangles)
        release_all(self._skin_program, self._cut_program)


def tissue_variation(rest: NDArray[np.floating], normals: NDArray[np.floating]) -> NDArray[np.float32]:
    """Per-vertex tissue of the rest shape: (vertex_count, 4) of occlusion (1), pallor, papillae, mottling.

    rest: (vertex_count, 3) [m], x anterior, z up; normals: (vertex_count, 3).
    The dorsum is paler and rough but for a thin red line along the median groove; sides and underside
    are red and smooth, and so is, towards the root, the back.
    """
    low, high = rest.min(axis=0), rest.max(axis=0)
    x = (rest[:, 0] - low[0]) / (high[0] - low[0])
    height = (rest[:, 2] - low[2]) / (high[2] - low[2])
    upward = _smoothstep(-0.15, 0.65, normals[:, 2] - 0.35 * normals[:, 0].clip(None, 0.0))
    upward *= 1.0 - _smoothstep(0.62, 0.42, height) * _smoothstep(0.35, 0.55, x)  # not below the tip
    front = _smoothstep(0.02, 0.45, x)
    beside = np.exp(-((rest[:, 1] / 0.0075) ** 2))
    groove = np.exp(-((rest[:, 1] / 0.0014) ** 2)) * _smoothstep(0.97, 0.85, x)
    rng = np.random.default_rng(3)
    waves = 2.0 * np.pi * rng.normal(size=(10, 3)) / 0.018
    mottling = np.cos(rest @ waves.T + 6.28 * rng.random(10)).mean(axis=1)
    tissue = np.ones((len(rest), 4), dtype=np.float32)
    tissue[:, 1] = upward * (0.35 + 0.65 * front) * (0.78 + 0.22 * beside - 0.55 * groove) + 0.35 * mottling * upward
    tissue[:, 2] = (0.04 + 0.94 * upward) * (0.5 + 0.5 * front)
    tissue[:, 3] = 0.20 * mottling
    return tissue


def _smoothstep(low: float, high: float, x: NDArray[np.floating]) -> NDArray[np.floating]:
    t = np.clip((x - low) / (high - low), 0.0, 1.0)
    return t * t * (3.0 - 2.0 * t)


def _colour_map_texture(context: moderngl.Context, name: str) -> moderngl.Texture:
    table = colour_table(name)
    texture = context.texture((len(table), 1), 3, table.tobytes(), alignment=1)
    texture.filter = (moderngl.LINEAR, moderngl.LINEAR)
    texture.repeat_x = texture.repeat_y = False
    return texture
