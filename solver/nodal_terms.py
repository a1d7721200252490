"""Forces on single nodes that are added to the elastic ones: contact, springs, anything with a 3x3 stiffness a node."""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..model import Control


class NodalTerm(Protocol):
    """One further term of the step's potential, a sum over nodes of functions of that node's displacement.

    nodes: the mesh's nodes it acts on, without repetition, (count,) int64; what it does to fixed ones is ignored.
    Displacements are (count, 3) [m], jaw frame, in the order of `nodes`.
    """

    nodes: NDArray[np.int64]

    def begin_step(self, displacement: NDArray[np.float64], control: Control, dt: float) -> None:
        """Takes the start of a step: damping refers to it, `control` may move obstacles."""
        ...

    def force(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Gradient of the term's energy [N], (count, 3): the sign is that of the elastic internal force."""
        ...

    def stiffness(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Its derivative or a symmetric positive semidefinite substitute [N/m], (count, 3, 3)."""
        ...


class NodalTerms:
    """The sum of several terms, as arrays over the free nodes.

    free_nodes: sorted nodes that move, (free_count,).
    """

    def __init__(self, terms: tuple[NodalTerm, ...], free_nodes: NDArray[np.int64]) -> None:
        self._free_count = len(free_nodes)
        self._terms = terms
        self._places = []
        for term in terms:
            held = ~np.isin(term.nodes, free_nodes)
            self._places.append((np.searchsorted(free_nodes, term.nodes[~held]), ~held))

    def _displacement(self, place: int, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        free, moves = self._places[place]
        result = np.zeros((len(moves), 3))
        result[moves] = displacement[free]
        return result

    def begin_step(self, displacement: NDArray[np.float64], control: Control, dt: float) -> None:
        """displacement of the free nodes at the start of the step [m], (free_count, 3)."""
        for n, term in enumerate(self._terms):
            term.begin_step(self._displacement(n, displacement), control, dt)

    def add_force(self, displacement: NDArray[np.float64], force_out: NDArray[np.floating]) -> None:
        """Adds every term's force [N] to that of the free nodes, (free_count, 3)."""
        for n, term in enumerate(self._terms):
            free, moves = self._places[n]
            force_out[free] += term.force(self._displacement(n, displacement))[moves]

    def stiffness(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Diagonal blocks of all terms together [N/m], (free_count, 3, 3)."""
        blocks = np.zeros((self._free_count, 3, 3))
        for n, term in enumerate(self._terms):
            free, moves = self._places[n]
            blocks[free] += term.stiffness(self._displacement(n, displacement))[moves]
        return blocks
