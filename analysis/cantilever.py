"""The load-end cantilever with three domains of Luo (2017, Fig. 7 left).

A bar of 90 x 15 x 10 mm clamped at x = 0, its far end loaded across. The paper does not give its sizes; the seeds
are put on the axis at one third, two thirds and the whole of the length, so that the load is at a seed as it is at a
sensor. Poisson's ratio is 0.3, since linear tetrahedra lock in bending near 0.5.
"""

import numpy as np
import scipy.sparse as sp

from ..model import EmbeddedSurface, Material, SensorLayout, TetMesh, TongueModel
from .static_bend import Bend, scaled_bend

SIZE = (0.090, 0.015, 0.010)
"""Length, width and height [m]."""
DIVISIONS = (36, 6, 4)
SEED_RADIUS = 0.0
"""A seed is one node, as in Eq. 13 of the paper."""
DOMAIN_COUNT = 3
REACH = 0.6
"""Displacement of the end in linear elasticity, in lengths; 0.4 or so after large rotations."""


def load_end_cantilever(divisions: tuple[int, int, int] = DIVISIONS) -> Bend:
    """The bar with its load, to be bent; its sensors are the three seeds. divisions: cells along x, y, z."""
    mesh = bar_mesh(SIZE, divisions)
    beam = TongueModel(
        name="cantilever",
        mesh=mesh,
        fixed_nodes=np.flatnonzero(mesh.nodes[:, 0] == 0.0),
        sensors=_seeds_on_axis(mesh),
        skin=_boundary(mesh),
        material=Material(poisson_ratio=0.3),
    )
    end = np.flatnonzero(np.isclose(mesh.nodes[:, 0], SIZE[0]))
    triangles = mesh.boundary_triangles[np.isin(mesh.boundary_triangles, end).all(axis=1)]
    corners = mesh.nodes[triangles]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    load = np.zeros_like(mesh.nodes)
    load[:, 2] = -np.bincount(triangles.ravel(), weights=np.repeat(area / 3.0, 3), minlength=mesh.node_count)
    return scaled_bend("cantilever", beam, load, end, REACH * SIZE[0])


def bar_mesh(size: tuple[float, float, float], divisions: tuple[int, int, int]) -> TetMesh:
    """A box [0, size] [m] of cells that are cut into five tetrahedra each, neighbours as mirror images.

    Five tetrahedra in alternation have no preferred diagonal, so a symmetric bar bends symmetrically.
    """
    shape = tuple(d + 1 for d in divisions)
    axes = [np.linspace(0.0, length, n) for length, n in zip(size, shape, strict=True)]
    nodes = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    index = np.arange(len(nodes)).reshape(shape)
    cells = np.indices(divisions).reshape(3, -1)
    # corner[:, a, b, c]: the node of a cell at offsets a, b, c along x, y, z.
    corner = np.stack([index[tuple(cells + np.array(o)[:, None])] for o in np.ndindex(2, 2, 2)], axis=1)
    odd = cells.sum(axis=0) % 2 == 1
    mirrored = corner.reshape(-1, 2, 2, 2)[:, ::-1].reshape(-1, 8)
    corner = np.where(odd[:, None], mirrored, corner)
    tets = np.concatenate([corner[:, list(t)] for t in _FIVE_TETRAHEDRA])
    turned = np.tile(odd, len(_FIVE_TETRAHEDRA))  # a mirror image turns them inside out
    tets[turned] = tets[turned][:, [0, 2, 1, 3]]
    return TetMesh(nodes, tets)


# Corners 4 a + 2 b + c of a cube: one tetrahedron in the middle and one at each of four corners.
_FIVE_TETRAHEDRA = ((0, 3, 5, 6), (1, 0, 3, 5), (2, 0, 6, 3), (4, 0, 5, 6), (7, 3, 6, 5))


def _seeds_on_axis(mesh: TetMesh) -> SensorLayout:
    """The nodes nearest to the axis at 1/3, 2/3 and the whole of the length."""
    axis = np.array([[share * SIZE[0], 0.5 * SIZE[1], 0.5 * SIZE[2]] for share in (1 / 3, 2 / 3, 1.0)])
    nearest = np.argmin(np.linalg.norm(mesh.nodes[None] - axis[:, None], axis=2), axis=1)
    return SensorLayout(("1/3", "2/3", "end"), _selection(nearest, mesh.node_count))


def _boundary(mesh: TetMesh) -> EmbeddedSurface:
    """The faceted boundary as display surface."""
    surface = mesh.boundary_nodes
    triangles = np.searchsorted(surface, mesh.boundary_triangles).astype(np.int32)
    return EmbeddedSurface(triangles, _selection(surface, mesh.node_count))


def _selection(nodes: np.ndarray, node_count: int) -> sp.csr_array:
    """Rows that pick the given nodes."""
    return sp.csr_array((np.ones(len(nodes)), (np.arange(len(nodes)), nodes)), shape=(len(nodes), node_count))
