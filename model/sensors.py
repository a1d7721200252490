"""Articulograph coils glued to the tongue's midline."""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from .errors import LingualError

SENSOR_NAMES = ("TT", "TB", "TD", "TR")
"""Tongue tip, blade, dorsum and rear, front to back."""


@dataclass(frozen=True, eq=False)
class SensorLayout:
    """Where the coils sit: each follows the weighted mean of the surface nodes under it.

    names: one per sensor.
    weights: (sensor_count, node_count) sparse, rows sum to one; row s spans the footprint of coil s
        (about 3 mm across, not one node: a point load on one node of a fine mesh makes a cusp).

    Raises LingualError when a row does not sum to one.
    """

    names: tuple[str, ...]
    weights: sp.csr_array

    def __post_init__(self) -> None:
        sums = np.asarray(self.weights.sum(axis=1)).ravel()
        if self.weights.shape[0] != len(self.names) or not np.allclose(sums, 1.0):
            raise LingualError("Every sensor needs a name and weights that sum to one over its nodes.")

    @property
    def count(self) -> int:
        return len(self.names)

    def positions(self, nodes: NDArray[np.floating]) -> NDArray[np.float64]:
        """Sensor positions (sensor_count, 3) for node positions (node_count, 3), in the same unit and frame."""
        return self.weights @ nodes

    def footprint(self, index: int) -> NDArray[np.int32]:
        """Indices of the nodes under sensor `index`."""
        return self.weights.indices[self.weights.indptr[index] : self.weights.indptr[index + 1]]
