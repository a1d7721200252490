"""Triangles of an implicit surface: surface nets, then projection on its zero level and relaxation.

A field f(points) is negative inside. Its values on a regular grid give one vertex in every cell that the
surface crosses and one quad across every grid edge whose ends differ in sign (naive surface nets, Gibson
1998, "Constrained elastic surface nets"). The vertices are then moved back and forth between a step towards
the mean of their neighbours in the tangent plane and a Newton step f / |grad f| along the gradient, which
removes the grid's terracing and leaves nearly equilateral triangles that lie on the surface.

Lengths are in the unit of the field's points (mm in `precompute.head`).
"""

from collections.abc import Callable

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from ..model.errors import LingualError

Field = Callable[[NDArray[np.float64]], NDArray[np.float64]]
"""Signed distance, exact or approximate, of points (n, 3): (n,), negative inside."""

_CHUNK = 40_000


def surface_of(
    field: Field,
    lower: tuple[float, float, float],
    upper: tuple[float, float, float],
    spacing: float,
    relaxation_count: int = 8,
) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Closed triangle surface of `field` inside the box from `lower` to `upper`.

    spacing: grid step, which is about the triangles' edge length. The box must contain the whole shape.
    relaxation_count: rounds of tangential smoothing and projection.
    Returns vertices (n, 3) and triangles (m, 3), outward.

    Raises LingualError when the box contains no surface or cuts it.
    """
    origin = np.asarray(lower, dtype=np.float64)
    shape = tuple(np.ceil((np.asarray(upper) - origin) / spacing).astype(int) + 1)
    values = _sample(field, origin, shape, spacing)
    inside = values < 0.0
    if not inside.any():
        raise LingualError("The shape has no inside in its sampling box: check its dimensions.")
    shell = np.ones(shape, dtype=bool)
    shell[1:-1, 1:-1, 1:-1] = False
    if (inside & shell).any():
        raise LingualError("The sampling box cuts through the shape: enlarge the box.")
    vertices, quads = _surface_nets(values)
    vertices = origin + spacing * vertices
    vertices = relax(field, vertices, quads, 0.5 * spacing, relaxation_count)
    return vertices, _split(vertices, quads)


def evaluate(field: Field, points: NDArray[np.float64]) -> NDArray[np.float64]:
    """field(points) in pieces, so that fields may use large temporaries, (n,)."""
    pieces = [field(points[i : i + _CHUNK]) for i in range(0, len(points), _CHUNK)]
    return np.concatenate(pieces) if pieces else np.zeros(0)


def gradient(field: Field, points: NDArray[np.float64], step: float = 0.02) -> NDArray[np.float64]:
    """Gradient of the field by central differences, (n, 3)."""
    out = np.empty_like(points)
    for axis in range(3):
        offset = np.zeros(3)
        offset[axis] = step
        out[:, axis] = (evaluate(field, points + offset) - evaluate(field, points - offset)) / (2.0 * step)
    return out


def project(
    field: Field, points: NDArray[np.float64], step_count: int = 2, reach: float = np.inf
) -> NDArray[np.float64]:
    """Points (n, 3) moved on the zero level by Newton steps no longer than `reach`."""
    for _ in range(step_count):
        slope = gradient(field, points)
        move = -evaluate(field, points)[:, None] * slope / np.maximum((slope**2).sum(1, keepdims=True), 1e-2)
        length = np.linalg.norm(move, axis=1, keepdims=True)
        points = points + move * np.minimum(1.0, reach / np.maximum(length, 1e-12))
    return points


def _sample(
    field: Field, origin: NDArray[np.float64], shape: tuple[int, ...], spacing: float, stride: int = 4
) -> NDArray[np.float64]:
    """Values on the grid, exact near the surface and interpolated from a coarser grid away from it."""
    coarse_shape = tuple((n + stride - 1) // stride + 1 for n in shape)
    coarse_axes = [origin[a] + stride * spacing * np.arange(coarse_shape[a]) for a in range(3)]
    coarse = evaluate(field, _points(coarse_axes)).reshape(coarse_shape)
    index = np.meshgrid(*[np.arange(n) / stride for n in shape], indexing="ij")
    values = map_coordinates(coarse, np.stack(index), order=1)
    near = np.abs(values) < 2.0 * stride * spacing
    fine_axes = [origin[a] + spacing * np.arange(shape[a]) for a in range(3)]
    values[near] = evaluate(field, _points(fine_axes)[near.ravel()])
    return values


def _points(axes: list[NDArray[np.float64]]) -> NDArray[np.float64]:
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def _surface_nets(values: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Vertices in grid units, (n, 3), and outward quads, (m, 4)."""
    cells = tuple(n - 1 for n in values.shape)
    total = np.zeros((*cells, 3))
    count = np.zeros(cells)
    for axis in range(3):
        a = np.moveaxis(values, axis, 0)
        crossing = (a[:-1] < 0.0) != (a[1:] < 0.0)
        difference = np.where(crossing, a[:-1] - a[1:], 1.0)
        where = np.moveaxis(np.where(crossing, a[:-1] / difference, 0.0), 0, axis)
        crossing = np.moveaxis(crossing, 0, axis)
        others = [b for b in range(3) if b != axis]
        for corner in np.ndindex(2, 2):
            window = [slice(None)] * 3
            for b, c in zip(others, corner, strict=True):
                window[b] = slice(c, c + cells[b])
            hit = crossing[tuple(window)]
            count += hit
            total[..., axis] += np.where(hit, where[tuple(window)], 0.0)
            for b, c in zip(others, corner, strict=True):
                total[..., b] += c * hit
    active = count > 0
    number = np.full(cells, -1, dtype=np.int64)
    number[active] = np.arange(int(active.sum()))
    corners = np.argwhere(active)
    vertices = corners + total[active] / count[active][:, None]
    return vertices, np.concatenate([_quads(values, number, axis) for axis in range(3)])


def _quads(values: NDArray[np.float64], number: NDArray[np.int64], axis: int) -> NDArray[np.int64]:
    """One outward quad around every interior grid edge along `axis` whose ends differ in sign, (m, 4)."""
    others = ((axis + 1) % 3, (axis + 2) % 3)
    order = (axis, *others)
    a = np.transpose(values, order)
    n = np.transpose(number, order)
    start, end = a[:-1, 1:-1, 1:-1], a[1:, 1:-1, 1:-1]
    around = np.stack([n[:, :-1, :-1], n[:, 1:, :-1], n[:, 1:, 1:], n[:, :-1, 1:]], axis=-1)
    leaving = (start < 0.0) & (end >= 0.0)  # the surface faces the axis' positive direction here
    entering = (start >= 0.0) & (end < 0.0)
    return np.concatenate([around[leaving], around[entering][:, ::-1]])


def relax(
    field: Field, vertices: NDArray[np.float64], faces: NDArray[np.integer], reach: float, count: int
) -> NDArray[np.float64]:
    """Vertices (n, 3) spread evenly over the zero level by `count` rounds of smoothing and projection.

    faces: triangles or quads, (m, 3 or 4). reach: longest step of a projection.
    """
    ends = np.stack([faces, np.roll(faces, -1, axis=1)], axis=-1).reshape(-1, 2)
    adjacency = sp.csr_array(
        (np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(len(vertices), len(vertices))
    )
    degree = adjacency.sum(axis=1)[:, None]
    vertices = project(field, vertices, step_count=1, reach=2.0 * reach)
    for _ in range(count):
        normal = gradient(field, vertices)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-12)
        move = (adjacency @ vertices) / degree - vertices
        move -= (move * normal).sum(axis=1, keepdims=True) * normal
        vertices = project(field, vertices + 0.7 * move, step_count=1, reach=reach)
    return project(field, vertices, step_count=2, reach=reach)


def _split(vertices: NDArray[np.float64], quads: NDArray[np.int64]) -> NDArray[np.int32]:
    """Triangles of the quads, each cut along its shorter diagonal, (2 m, 3)."""
    corner = vertices[quads]
    first = np.linalg.norm(corner[:, 0] - corner[:, 2], axis=1)
    second = np.linalg.norm(corner[:, 1] - corner[:, 3], axis=1)
    cut = np.where((first <= second)[:, None, None], [[0, 1, 2], [0, 2, 3]], [[0, 1, 3], [1, 2, 3]])
    return np.take_along_axis(quads[:, None, :], cut, axis=2).reshape(-1, 3).astype(np.int32)
