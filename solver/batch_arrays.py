"""The arrays of a batch of reduced tongues: its state, and what a step works on. The tongue is the last index."""

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.precision import precision
from ..model import ReducedModel

PAIRS, CAPTURED_PAIRS = 16, 4
"""Curvature pairs that a tongue remembers, also from earlier steps; on CUDA each costs two waits in a block."""


class BatchArrays:
    """Allocated once. n = 3 columns unknowns, T tongues, c imposed sensor coordinates, E cubature elements.

    extended: (columns + 3, 3, T): the coordinates, then the identity, which carries the rest shape through the
    skinning product. coordinates: its first rows. velocity: (columns, 3, T). target, constrained: (c, T) [m].
    position: (node_count, 3, T) [m]. gradient_start, gradient_increment: (3 E, 3, T). stacked: (3 E + points, 3, T):
    element stresses, then forces at collision points; one product reduces both.
    The others are vectors (n, T), pairs (pairs, n, T) and scalars (T,) as `kernels.quasi_newton` names them;
    constraint_force: (c, T) filled up to a multiple of four.
    """

    def __init__(
        self,
        model: ReducedModel,
        constraint_count: int,
        point_count: int,
        tongue_count: int,
        precision_name: str,
        device: str,
    ) -> None:
        self.device = device
        self._scalar = precision(precision_name).scalar
        self._on_host = bool(wp.get_device(device).is_cpu)
        self._inboxes: list[tuple[wp.array, wp.array]] = []
        zeros, T = self.zeros, tongue_count
        K, n = model.column_count, model.dof_count
        self.extended = zeros(K + 3, 3, T)
        host = np.zeros((K + 3, 3, T))
        host[K:] = np.eye(3)[:, :, None]
        self.extended.assign(host)
        self.coordinates, self.velocity = self.extended[:K], zeros(K, 3, T)
        self.target, self.constrained = zeros(constraint_count, T), zeros(constraint_count, T)
        self.constraint_force = zeros(4 * -(-constraint_count // 4), T)
        self.position = zeros(model.tongue.mesh.node_count, 3, T)
        rows = 3 * len(model.cubature_elements)
        self.gradient_start, self.gradient_increment = zeros(rows, 3, T), zeros(rows, 3, T)
        self.stacked = zeros(rows + point_count, 3, T)
        self.predicted, self.trial, self.direction, self.accepted = (zeros(n, T) for _ in range(4))
        self.gradient, self.fresh, self.force, self.load, self.q, self.z = (zeros(n, T) for _ in range(6))
        pairs = PAIRS if self._on_host else CAPTURED_PAIRS
        self.pair_step, self.pair_change = zeros(pairs, n, T), zeros(pairs, n, T)
        self.pair_scale, self.pair_share = zeros(pairs, T), zeros(pairs, T)
        self.pair_count, self.state = (wp.zeros(T, dtype=wp.int32, device=device) for _ in range(2))
        self.length, self.slope, self.error = zeros(T), zeros(T), zeros(T)

    def zeros(self, *shape: int) -> wp.array:
        """An array of the batch's precision on its device."""
        return wp.zeros(shape, dtype=self._scalar, device=self.device)

    def array(self, values: NDArray | list, dtype: type | None = None) -> wp.array:
        """Values on the device, in the batch's precision unless another type is named."""
        return wp.array(values, dtype=dtype or self._scalar, device=self.device)

    @property
    def pairs(self) -> list[wp.array]:
        """What the two halves of an iteration share of the curvature pairs, in the kernels' order."""
        return [self.pair_step, self.pair_change, self.pair_scale, self.pair_share, self.pair_count]

    def by_degree(self, values: wp.array) -> wp.array:
        """(columns, 3, T) seen as (n, T)."""
        return values.reshape((3 * values.shape[0], values.shape[2]))

    def by_column(self, values: wp.array) -> wp.array:
        """(n, T) seen as (columns, 3, T)."""
        return values.reshape((values.shape[0] // 3, 3, values.shape[1]))

    def inbox(self, array: wp.array) -> wp.array:
        """Memory of the host that a step reads by itself: on a CPU the array, on CUDA a pinned copy of it."""
        if self._on_host:
            return array
        inbox = wp.zeros(array.shape, dtype=array.dtype, device="cpu", pinned=True)
        inbox.numpy()[:] = array.numpy()
        self._inboxes.append((array, inbox))
        return inbox

    def await_inboxes(self) -> None:
        """Waits until the step that reads the inboxes is over, so that they may be written."""
        if not self._on_host:
            wp.synchronize_stream(wp.get_stream(self.device))

    def read_inboxes(self) -> None:
        """Copies the inboxes to the device; part of a captured step."""
        for array, inbox in self._inboxes:
            wp.copy(array, inbox)
