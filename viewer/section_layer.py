"""A scalar on the midsagittal section of the tongue, where the clipping plane opens it."""

import moderngl
import numpy as np

from ..model import TetMesh
from ..model.history import Sample
from .cross_section import cross_section
from .gl_resources import release_all
from .session_view import ScalarField
from .shader_program import load_program, set_uniform

_START = 4096  # corners reserved at first; grows when a section has more


class SectionLayer:
    """Cuts the tetrahedra anew for every instant; a few milliseconds, and only while it is shown."""

    def __init__(self, context: moderngl.Context, mesh: TetMesh) -> None:
        self._context = context
        self._tets = mesh.tets
        self._program = load_program(context, "section", "section")
        self._corners = context.buffer(reserve=16 * _START, dynamic=True)
        self._mesh = context.vertex_array(self._program, [(self._corners, "3f 1f", "in_position", "in_scalar")])
        self._count = 0

    def update(self, sample: Sample, scalar: ScalarField, midline: float = 0.0) -> None:
        """Uploads the section of the deformed tongue at y = midline [m, head frame] with the scalar on it."""
        height = sample.nodes[:, 1] + np.float32(sample.jaw_translation[1] - midline)
        nodes, weight = cross_section(self._tets, height)
        values = np.column_stack([sample.nodes + sample.jaw_translation, scalar.fraction()]).astype(np.float32)
        first, second = values[nodes[:, 0]], values[nodes[:, 1]]
        corners = first + weight[:, None] * (second - first)
        if scalar.categories:  # one to a triangle: that of a node at its first corner
            corners[:, 3] = np.repeat(first[::3, 3], 3)
        self._count = len(corners)
        if self._count:
            self._corners.orphan(max(corners.nbytes, self._corners.size))
            self._corners.write(corners)

    def draw(self, colour_map: moderngl.Texture) -> None:
        """Draws the section in the scalar's colours; the plane faces the eye."""
        self._context.enable_only(moderngl.DEPTH_TEST)
        colour_map.use(1)
        set_uniform(self._program, "colour_map", 1)
        if self._count:
            self._mesh.render(moderngl.TRIANGLES, vertices=self._count)

    def release(self) -> None:
        """Frees everything on the graphics device."""
        release_all(self._mesh, self._corners, self._program)
