"""Reading a grid of spline coefficients, and closest-point queries, against SciPy and closed forms."""

import numpy as np
import pytest
import warp as wp
from scipy.ndimage import map_coordinates

from lingual.kernels.signed_distance import FAR, TOUCH_REACH, distance_functions, mesh_distance_kernel

RNG = np.random.default_rng(7)
SHAPE = (7, 8, 9)
LOWER, SPACING = np.array([-0.01, 0.02, 0.005]), 0.002
VALUES = RNG.standard_normal(SHAPE).astype(np.float32)


@pytest.fixture
def sample(types, device):
    """Function (values, points, precision name) -> distance (n,) and gradient (n, 3) of the test's grid."""

    def run(values, points, name=types.numpy.name):
        functions = distance_functions(name)
        grid = functions.Grid()
        grid.values = wp.array(values, dtype=wp.float32, device=device)
        scalar = getattr(wp, name)
        vec3 = wp.types.vector(length=3, dtype=scalar)
        grid.lower, grid.spacing = vec3(*LOWER), scalar(SPACING)
        out = wp.zeros(len(points), dtype=functions.vec4, device=device)
        at = wp.array(points, dtype=vec3, device=device)
        wp.launch(functions.sample, len(points), [grid, at], [out], device=device)
        return out.numpy()[:, 0], out.numpy()[:, 1:]

    return run


def inner_points(count: int) -> np.ndarray:
    """Points that have coefficients all around."""
    return LOWER + SPACING * RNG.uniform(0.5, np.array(SHAPE) - 1.5, (count, 3))


def test_value_is_that_of_the_quadratic_spline(sample, types):
    points = inner_points(200)
    index = ((points - LOWER) / SPACING).T
    expected = map_coordinates(VALUES.astype(np.float64), index, order=2, prefilter=False)
    tolerance = 1e-12 if types.numpy == np.float64 else 2e-5
    assert sample(VALUES, points)[0] == pytest.approx(expected, abs=tolerance)


def test_gradient_is_the_derivative_of_the_value(sample):
    points, step = inner_points(100), 1e-7
    _, gradient = sample(VALUES, points, "float64")
    for axis, unit in enumerate(np.eye(3)):
        ahead, behind = (sample(VALUES, points + sign * step * unit, "float64")[0] for sign in (1, -1))
        assert gradient[:, axis] == pytest.approx((ahead - behind) / (2 * step), abs=1e-3 * np.abs(gradient).max())


def test_gradient_is_continuous_across_cells(sample):
    """The force of a contact must not jump anywhere."""
    cell = np.array([3, 4, 4]) + 0.5
    on_corner = LOWER + SPACING * cell
    around = on_corner + 1e-9 * RNG.choice([-1.0, 1.0], (50, 3))
    _, gradient = sample(VALUES, around, "float64")
    assert np.ptp(gradient, axis=0).max() < 1e-4 * np.abs(gradient).max()


def test_a_plane_is_reproduced(sample, types):
    normal = np.array([2.0, -1.0, 2.0]) / 3.0
    centre = LOWER + SPACING * np.array(SHAPE) / 2
    grid = LOWER + SPACING * np.moveaxis(np.indices(SHAPE), 0, -1)
    points = inner_points(50)
    distance, gradient = sample((grid - centre) @ normal, points)
    assert distance == pytest.approx((points - centre) @ normal, abs=1e-8)  # coefficients are in single precision
    assert gradient == pytest.approx(np.tile(normal, (50, 1)), abs=1e-5)


def test_nothing_is_touched_outside_the_grid(sample):
    far = LOWER + SPACING * np.array([[-3.0, 4, 4], [3, 20, 4], [3, 4, 1e12], [0.4, 4, 4], [3, 4, 7.6]])
    distance, gradient = sample(np.full(SHAPE, -1.0), far)
    assert distance == pytest.approx(FAR)
    assert not gradient.any()


def test_may_touch_never_misses_a_contact(device):
    """A point inside a body has a coefficient near it that is small enough, also beside a thin edge."""
    functions = distance_functions("float64")
    grid_points = np.moveaxis(np.indices((20, 20, 20)), 0, -1) - 9.5
    edge = np.abs(grid_points[..., 0]) + np.abs(grid_points[..., 1]) - 2.0  # a prism four spacings wide
    grid = functions.Grid()
    grid.values = wp.array(edge / np.sqrt(2.0), dtype=wp.float32, device=device)
    vec3d = wp.types.vector(length=3, dtype=wp.float64)
    grid.lower, grid.spacing = vec3d(-9.5, -9.5, -9.5), wp.float64(1.0)

    @wp.kernel(module="unique")
    def both(g: functions.Grid, at: wp.array(dtype=vec3d), out: wp.array(dtype=wp.float64, ndim=2)):
        i = wp.tid()
        out[i, 0] = functions.signed_distance(g, at[i])[0]
        out[i, 1] = wp.where(functions.may_touch(g, at[i]), wp.float64(1.0), wp.float64(0.0))

    points = wp.array(RNG.uniform(-6, 6, (4000, 3)), dtype=vec3d, device=device)
    out = wp.zeros((4000, 2), dtype=wp.float64, device=device)
    wp.launch(both, 4000, [grid, points], [out], device=device)
    distance, may = out.numpy().T
    assert (distance < 0.0).sum() > 20
    assert may[distance < 0.0].all()
    assert not may[distance > TOUCH_REACH + 2.0].any()


def test_mesh_distance_lowers_to_the_signed_distance_of_a_box():
    box = np.array(np.meshgrid([-1.0, 1], [-2.0, 2], [-3.0, 3], indexing="ij")).reshape(3, -1).T
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], dtype=np.int32)
    mesh = wp.Mesh(
        wp.array(box, dtype=wp.vec3f, device="cpu"),
        wp.array(triangles.ravel(), dtype=wp.int32, device="cpu"),
        support_winding_number=True,
    )
    points = RNG.uniform(-4, 4, (500, 3)).astype(np.float32)
    q = np.abs(points) - [1.0, 2.0, 3.0]
    expected = np.linalg.norm(np.maximum(q, 0), axis=1) + np.minimum(q.max(axis=1), 0)
    out = wp.array(np.full(500, 1.5), dtype=wp.float32, device="cpu")
    at = wp.array(points, dtype=wp.vec3f, device="cpu")
    wp.launch(mesh_distance_kernel(), 500, [mesh.id, at, 10.0], [out], device="cpu")
    assert out.numpy() == pytest.approx(np.minimum(expected, 1.5), abs=1e-5)
