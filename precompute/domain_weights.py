"""Weight of every quadratic domain at every node, from elastostatics (Luo 2017, section 7, Eq. 12-14).

For domain j: with all other seeds and the attached nodes held, unit forces on its seed along x, y, z
give the response U (3 node_count, 3); the principal direction p, along which a unit force moves the
tongue most, is the eigenvector of U^T U with the largest eigenvalue. The weight is then the component
along p of the displacement when the seed is moved by p while every anchor is held along p only and
may slide across it.

Departures from the paper: the attached nodes are anchors, and the ground they stand for counts as one
more domain whose coordinates are zero: weights are clipped to [0, 1] and divided by max(1, sum), so
that they never exceed a partition of unity and attached nodes do not move. A seed is a footprint, not
a node. The response to a load on a footprint still has a cusp there, and valleys at the other seeds,
whose slope turns small elements inside out when the tongue moves far; so the weights are diffused over
`DIFFUSION_LENGTH`, which costs the interpolation property that sensor constraints make superfluous
(docs/design/domain_weights.md has the measurements).
"""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..model import TongueModel
from ..model.discretisation import Discretisation
from ..model.sparse_factor import factorise
from .progress import Progress, silent
from .seeds import Seed

DIFFUSION_LENGTH = 3e-3
"""Distance [m] over which one of the two diffusion steps smooths: the size of a coil."""
DIFFUSION_STEPS = 2


def domain_weights(
    tongue: TongueModel,
    seeds: list[Seed],
    diffusion_length: float = DIFFUSION_LENGTH,
    progress: Progress = silent,
) -> NDArray[np.float64]:
    """Weights (node_count, domain_count) in [0, 1], rows summing to one or less, zero at fixed nodes."""
    discretisation = Discretisation(tongue.mesh, tongue.material)
    discretisation.set_displacement(np.zeros((tongue.mesh.node_count, 3)))
    stiffness = discretisation.stiffness().tocsr()
    raw = np.empty((tongue.mesh.node_count, len(seeds)))
    for j, seed in enumerate(seeds):
        progress("domain weights", j / len(seeds))
        others = [s.nodes for i, s in enumerate(seeds) if i != j]
        anchors = np.unique(np.concatenate([*others, tongue.fixed_nodes]))
        direction = principal_direction(stiffness, seed.nodes, anchors)
        raw[:, j] = response_along(stiffness, seed.nodes, anchors, direction)
    progress("domain weights", 1.0)
    return diffuse(tongue, blend_with_ground(raw, tongue.fixed_nodes), diffusion_length)


def diffuse(tongue: TongueModel, weights: NDArray[np.float64], length: float) -> NDArray[np.float64]:
    """Implicit diffusion steps (V + l^2 L) w' = V w with natural boundary, zero at the fixed nodes.

    V: node volumes, L: the linear-element Laplacian, l: `length` [m], zero for none.
    Keeps [0, 1] up to a clip, since the steps average.
    """
    mesh, free = tongue.mesh, tongue.free_nodes
    gradients = mesh.shape_gradients
    local = np.einsum("eai,ebi,e->eab", gradients, gradients, mesh.volumes)
    rows = np.repeat(mesh.tets, 4, axis=1).ravel()
    columns = np.tile(mesh.tets, (1, 4)).ravel()
    shape = (mesh.node_count, mesh.node_count)
    laplacian = sp.csr_array((local.ravel(), (rows, columns)), shape=shape)
    volume = sp.diags_array(mesh.node_volumes[free])
    factor = factorise(volume + length**2 * laplacian[free][:, free])
    smooth = np.zeros_like(weights)
    smooth[free] = weights[free]
    for _ in range(DIFFUSION_STEPS):
        smooth[free] = factor.solve(volume @ smooth[free])
    return np.clip(smooth, 0.0, 1.0)


def blend_with_ground(raw: NDArray[np.float64], fixed_nodes: NDArray[np.int64]) -> NDArray[np.float64]:
    """Clips to [0, 1] and divides rows by max(1, sum); the missing part of each row is the ground's."""
    weights = np.clip(raw, 0.0, 1.0)
    weights[fixed_nodes] = 0.0
    return weights / np.maximum(1.0, weights.sum(axis=1, keepdims=True))


def principal_direction(
    stiffness: sp.csr_array, seed: NDArray[np.int64], anchors: NDArray[np.int64]
) -> NDArray[np.float64]:
    """Unit direction (3,) in which a unit force on the seed moves the body most (Eq. 14)."""
    size = stiffness.shape[0]
    free = np.setdiff1d(np.arange(size), _dofs(anchors))
    force = np.zeros((size, 3))
    for axis in range(3):
        force[3 * seed + axis, axis] = 1.0 / len(seed)
    response = factorise(stiffness[free][:, free]).solve(force[free])
    _, vectors = np.linalg.eigh(response.T @ response)
    return vectors[:, -1]


def response_along(
    stiffness: sp.csr_array,
    seed: NDArray[np.int64],
    anchors: NDArray[np.int64],
    direction: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Component along `direction` of the displacement when the seed moves by it, (node_count,)."""
    size = stiffness.shape[0]
    tangents = np.linalg.svd(direction[None])[2][1:]  # two unit vectors across the direction
    sliding = np.repeat(np.arange(2 * len(anchors)), 3)
    slide_rows = (3 * np.repeat(anchors, 2)[:, None] + np.arange(3)).ravel()
    slide = sp.coo_array((np.tile(tangents, (len(anchors), 1)).ravel(), (slide_rows, sliding)))
    free = np.setdiff1d(np.arange(size), np.concatenate([_dofs(anchors), _dofs(seed)]))
    identity = sp.coo_array((np.ones(len(free)), (free, np.arange(len(free)))), shape=(size, len(free)))
    slide = sp.coo_array((slide.data, slide.coords), shape=(size, 2 * len(anchors)))
    reduce = sp.hstack([identity, slide]).tocsr()
    prescribed = np.zeros(size)
    prescribed[_dofs(seed)] = np.tile(direction, len(seed))
    right = -(reduce.T @ (stiffness @ prescribed))
    displacement = prescribed + reduce @ factorise(reduce.T @ stiffness @ reduce).solve(right)
    return displacement.reshape(-1, 3) @ direction


def _dofs(nodes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Indices 3 n + i of the coordinates of the given nodes."""
    return (3 * nodes[:, None] + np.arange(3)).ravel()
