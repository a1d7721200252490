"""How a tongue at rest gives way to one seed while the others and the ground hold (Luo 2017, Eq. 12-14).

With K the stiffness at rest, every seed a set of nodes and the attached nodes the ground, all of them held except
seed s, unit forces on s along x, y, z give the response U (3 node_count, 3); its principal directions are the
eigenvectors of A = U^T U, the last one that in which a unit force moves the tongue most (Eq. 14).

The interior, the nodes that are neither seed nor ground, is factorised once: with Z = K_ii^-1 K_is the seed
itself sees the Schur complement K_ss - K_is^T Z, so the directions of all seeds need one factor. A response
with anchors that slide across p has a boundary condition of its own and needs a factor for each seed.
"""

from functools import cached_property

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..model.sparse_factor import factorise
from .seeds import Seed


class SeedResponse:
    """Linear responses to the seeds of one tongue.

    stiffness: K at rest [N/m], (3 node_count, 3 node_count). seeds: disjoint sets of free nodes.
    fixed_nodes: the ground.
    """

    def __init__(self, stiffness: sp.csr_array, seeds: list[Seed], fixed_nodes: NDArray[np.int64]) -> None:
        self._stiffness = stiffness
        self._seeds = [seed.nodes for seed in seeds]
        self._fixed_nodes = fixed_nodes
        held = np.concatenate([*self._seeds, fixed_nodes])
        self._interior = np.setdiff1d(np.arange(stiffness.shape[0]), coordinates_of(held))

    @cached_property
    def _interior_factor(self):  # type: ignore[no-untyped-def]
        return factorise(self._stiffness[self._interior][:, self._interior])

    def directions(self, index: int) -> NDArray[np.float64]:
        """Unit directions (3, 3) as rows, from the least to the most deformable one, of seed `index`."""
        seed = coordinates_of(self._seeds[index])
        coupling = self._stiffness[self._interior][:, seed].toarray()
        solved = self._interior_factor.solve(coupling)
        seen = self._stiffness[seed][:, seed].toarray() - coupling.T @ solved
        force = np.tile(np.eye(3), (len(seed) // 3, 1)) * (3.0 / len(seed))
        moved = np.linalg.solve(seen, force)
        inside = solved @ moved
        _, vectors = np.linalg.eigh(moved.T @ moved + inside.T @ inside)
        return vectors.T

    def with_anchors_fixed(self, index: int, direction: NDArray[np.float64]) -> NDArray[np.float64]:
        """Component along `direction` (3,) of the displacement when seed `index` moves by it and every
        anchor is held in all components; (node_count,)."""
        displacement = self._prescribed(index, direction)
        load = (self._stiffness @ displacement)[self._interior]
        displacement[self._interior] = -self._interior_factor.solve(load)
        return displacement.reshape(-1, 3) @ direction

    def with_anchors_sliding(self, index: int, direction: NDArray[np.float64]) -> NDArray[np.float64]:
        """As `with_anchors_fixed`, but anchors are held along `direction` only and may slide across it."""
        size = self._stiffness.shape[0]
        others = [nodes for i, nodes in enumerate(self._seeds) if i != index]
        anchors = np.concatenate([*others, self._fixed_nodes])
        across = np.linalg.svd(direction[None])[2][1:]  # two unit vectors
        rows = np.repeat(coordinates_of(anchors).reshape(-1, 3), 2, axis=0)
        values = np.tile(across, (len(anchors), 1))
        columns = len(self._interior) + np.repeat(np.arange(2 * len(anchors)), 3)
        # u = prescribed + free_motion @ unknowns: interior coordinates, then two amplitudes for each anchor.
        free_motion = sp.csr_array(
            (
                np.concatenate([np.ones(len(self._interior)), values.ravel()]),
                (
                    np.concatenate([self._interior, rows.ravel()]),
                    np.concatenate([np.arange(len(self._interior)), columns]),
                ),
            ),
            shape=(size, len(self._interior) + 2 * len(anchors)),
        )
        prescribed = self._prescribed(index, direction)
        reduced = free_motion.T @ self._stiffness @ free_motion
        unknowns = factorise(reduced).solve(-(free_motion.T @ (self._stiffness @ prescribed)))
        return (prescribed + free_motion @ unknowns).reshape(-1, 3) @ direction

    def _prescribed(self, index: int, direction: NDArray[np.float64]) -> NDArray[np.float64]:
        """Displacement (3 node_count,) of the seed alone by `direction`."""
        displacement = np.zeros((self._stiffness.shape[0] // 3, 3))
        displacement[self._seeds[index]] = direction
        return displacement.ravel()


def coordinates_of(nodes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Indices 3 n + i of the coordinates of the given nodes."""
    return (3 * nodes[:, None] + np.arange(3)).ravel()
