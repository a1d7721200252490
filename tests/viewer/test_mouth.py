"""What the rigid parts of the mouth add to the picture: shade on the tongue, gums, one veil of bone."""

import numpy as np
import pytest
from synthetic_session import SyntheticSession, box, mouth

from lingual.model import RigidSurface
from lingual.viewer.closeness import REACH, closeness
from lingual.viewer.detail import FULL_DETAIL, DisplaySurface, display_surfaces
from lingual.viewer.offscreen import OffscreenRenderer
from lingual.viewer.rigid_mesh import merged_triangles, vertex_data
from lingual.viewer.scene import default_camera, subject
from lingual.viewer.tissues import TISSUES
from lingual.viewer.view_options import ViewOptions


def shown(*surfaces: RigidSurface) -> tuple[DisplaySurface, ...]:
    return display_surfaces(surfaces, FULL_DETAIL)


def dense(points: np.ndarray, tissue: str, frame: str) -> DisplaySurface:
    return DisplaySurface(tissue, frame, points, np.zeros((0, 3), np.int32), np.zeros_like(points))


def test_closeness_is_one_in_contact_and_zero_beyond_reach():
    rng = np.random.default_rng(0)
    rest = rng.uniform(-0.02, 0.02, (50, 3))
    x, y = np.meshgrid(np.linspace(-0.03, 0.03, 121), np.linspace(-0.03, 0.03, 121))
    plane = np.stack([x.ravel(), y.ravel(), np.full(x.size, 0.01)], axis=1)
    grid = closeness(rest, (dense(plane, "mucosa", "head"), dense(plane, "bone", "jaw")))
    count = np.array(grid.values.shape[2::-1])
    z = grid.low[2] + (np.arange(count[2]) + 0.5) * (grid.high[2] - grid.low[2]) / count[2]
    column = grid.values[:, count[1] // 2, count[0] // 2, 0] / 255.0
    assert column == pytest.approx(np.clip(1.0 - np.abs(z - 0.01) / REACH, 0.0, 1.0), abs=0.03)
    assert not grid.values[..., 1].any()  # bone does not count


def test_gum_is_mucosa_at_teeth_and_hides_what_is_in_it(gl):
    gum = RigidSurface("gums", "mucosa", "jaw", *box((0.0, 0.0, 0.0), (0.006, 0.006, 0.006)))
    away = RigidSurface("palate", "mucosa", "jaw", *box((0.1, 0.0, 0.0), (0.006, 0.006, 0.006)))
    tooth = RigidSurface("tooth", "tooth", "jaw", *box((0.0, 0.0, 0.003), (0.004, 0.004, 0.008)))
    kind = vertex_data(gl, shown(gum, away, tooth))[:, 6:]
    assert kind[:8, 3].min() > 0.5
    assert kind[8:16, 3].max() == 0.0
    root = tooth.vertices[:, 2] < 0.0
    assert kind[16:, 3][root].min() > 0.5
    assert kind[16:, 3][~root].max() == 0.0


def test_open_surfaces_get_both_sides():
    surfaces = shown(*mouth())
    triangles, part = merged_triangles(surfaces)
    counts = np.bincount(part)
    assert counts[0] == 2 * len(surfaces[0].triangles)  # the palate is a sheet
    assert counts[1] == len(surfaces[1].triangles)
    assert triangles.max() == sum(len(s.vertices) for s in surfaces) - 1


def test_bone_behind_bone_is_not_seen():
    """Two plates of bone, one behind the other, look like one."""
    pictures = []
    for count in (1, 2, 0):
        session = SyntheticSession(simulated=0.0)
        plates = [
            RigidSurface("plate", "bone", "jaw", *box((-0.035, y, 0.02), (0.05, 0.004, 0.03)))
            for y in (0.03, -0.03)[:count]
        ]
        object.__setattr__(session.model, "rigid", tuple(plates))
        camera = default_camera(SyntheticSession(simulated=0.0).model, "lateral")
        with OffscreenRenderer(session, 160, 120) as renderer:
            options = ViewOptions(show_sensors=False, show_tongue=False)
            pictures.append(renderer.render(0.0, camera=camera, options=options)[..., :3].astype(int))
    inside = np.abs(pictures[0] - pictures[2]).sum(axis=2) > 6  # where the first plate is
    assert inside.sum() > 1000
    assert pictures[0][inside].std(axis=0).max() < 25.0  # an even veil
    # The last rows and columns of the nearer plate's outline are mixed with what is behind it.
    assert np.quantile(np.abs(pictures[1] - pictures[0]).sum(axis=2)[inside], 0.95) <= 2


def test_teeth_are_opaque_and_everything_else_is_not():
    assert min(TISSUES["tooth"].opacity) == 1.0
    assert max(TISSUES["bone"].opacity) < 1.0
    assert max(TISSUES["mucosa"].opacity) < 1.0


def test_the_rami_do_not_frame_the_picture():
    model = SyntheticSession(simulated=0.0).model
    points = subject(model)
    far = RigidSurface("ramus", "bone", "jaw", *box((-0.09, 0.05, 0.05), (0.01, 0.01, 0.05)))
    object.__setattr__(model, "rigid", (*model.rigid, far))
    assert np.array_equal(subject(model), points)
