"""Forces between selected points of the tongue and the rigid mouth, implicit in a solver's step.

Damped springs after Luo (2017, section 8, "Other implementation details"); `kernels/contact.py` states the
potential. Departures: the springs carry the area that a point stands for, so that stiffness does not depend on
the mesh; the damping cannot pull a leaving point back; both are part of the implicit step.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.contact import contact_kernels
from ..kernels.precision import precision
from ..kernels.reduced import COMPONENT_PAIRS
from .contact_depth import ContactDepth, JawPoses, recorded_launch
from .signed_distance import SignedDistanceGrid

STIFFNESS = 5e7
"""Pressure for each metre of depth [Pa/m]."""
DAMPING = 2e-3
"""Damping for each unit of stiffness [s]."""
STIFFNESS_COMPONENTS = len(COMPONENT_PAIRS)
"""Of a point's symmetric stiffness: xx, xy, xz, yy, yz, zz."""


@dataclass(frozen=True, eq=False)
class CollisionPoints:
    """Surface nodes that stand for the whole surface in contact (Luo 2017, Fig. 8).

    nodes: (point_count,) indices of mesh nodes. areas: (point_count,) [m^2], what each stands for.
    seen_share: share of the training poses' penetrating nodes that have a penetrating point close by.
    missed_depth: deepest of the others [m].
    """

    nodes: NDArray[np.int64]
    areas: NDArray[np.float64]
    seen_share: float = float("nan")
    missed_depth: float = float("nan")


class ContactForces:
    """Force and stiffness of contact springs for `tongue_count` tongues.

    rest: (point_count, 3) [m], jaw frame; areas: (point_count,) [m^2]. grids: of the rigid parts.
    stiffness: [Pa/m]; damping: [s]. displacement, force: arrays of the caller's to read and to write, such as
    rows of stacked ones; own ones by default. On `device`, with T = tongue_count:

    displacement, displacement_start: (point_count, 3, T) [m], jaw frame, at the end and start of the step; read.
    poses, poses_start: of the jaw at those times; read.
    force: (point_count, 3, T) [N], the potential's gradient; stiffness: (point_count, 6, T) [N/m],
    Gauss-Newton, order xx, xy, xz, yy, yz, zz; depth: (2, point_count, T) [m], as in ContactDepth; written.
    """

    def __init__(
        self,
        rest: NDArray[np.float64],
        areas: NDArray[np.float64],
        grids: tuple[SignedDistanceGrid, ...],
        stiffness: float = STIFFNESS,
        damping: float = DAMPING,
        tongue_count: int = 1,
        precision_name: str = "float64",
        device: str = "cpu",
        displacement: wp.array | None = None,
        force: wp.array | None = None,
    ) -> None:
        common = (grids, tongue_count, precision_name, device)
        self._end = ContactDepth(rest, *common, displacement=displacement)
        self._start = ContactDepth(rest, *common)
        self._kernels = contact_kernels(precision_name)
        self._scalar = precision(precision_name).scalar
        self._damping = damping
        self._step: float | None = None
        self.device = device
        self.shape = self._end.shape
        self._spring: wp.array = wp.array(stiffness * areas, dtype=self._scalar, device=device)
        points = len(rest)
        self.force = self._zeros(points, 3, tongue_count) if force is None else force
        self.stiffness = self._zeros(points, STIFFNESS_COMPONENTS, tongue_count)
        self._energy = self._zeros(tongue_count)

    def _zeros(self, *shape: int) -> wp.array:
        return wp.zeros(shape, dtype=self._scalar, device=self.device)

    @property
    def displacement(self) -> wp.array:
        return self._end.displacement

    @property
    def displacement_start(self) -> wp.array:
        return self._start.displacement

    @property
    def poses(self) -> JawPoses:
        return self._end.poses

    @property
    def poses_start(self) -> JawPoses:
        return self._start.poses

    @property
    def depth(self) -> wp.array:
        return self._end.depth

    def begin_step(self) -> None:
        """Evaluates the depths at the start of the step, to which the damping refers."""
        self._start.evaluate()

    @cached_property
    def _force_launch(self) -> wp.Launch | None:
        inputs = [*self._end.inputs, self._spring, self._start.depth, self._scalar(0.0)]
        outputs = [self.force, self.stiffness, self.depth]
        return recorded_launch(self._kernels.force, self.shape, inputs, outputs, self.device)

    def _damping_over_step(self, step: float | None) -> object:
        return self._scalar(self._damping / step if step else 0.0)

    def evaluate(self, step: float | None = None) -> None:
        """Fills `force`, `stiffness` and `depth`; with the damping of a step of `step` seconds when given."""
        if self._force_launch is not None:
            self._force_launch.set_param_by_name("damping_over_step", self._damping_over_step(step))
            self._force_launch.launch()

    def stiffness_product(self, direction: wp.array, product: wp.array) -> Callable[[], None]:
        """A call that computes product = stiffness times direction, both (point_count, 3, T)."""
        inputs = [self.stiffness, direction]
        launch = recorded_launch(self._kernels.stiffness_product, self.shape, inputs, [product], self.device)
        return launch.launch if launch is not None else lambda: None

    def summarise(self) -> None:
        """Fills `deepest` (T,) [m] and `contact_count` (T,) on the device from the depths evaluated last."""
        self._end.summarise()

    @property
    def deepest(self) -> wp.array:
        return self._end.deepest

    @property
    def contact_count(self) -> wp.array:
        return self._end.contact_count

    def energy(self, step: float | None = None) -> NDArray[np.floating]:
        """Potential [J] of each tongue's springs, (T,), at the depths evaluated last.

        The stored energy, or the incremental potential of a step of `step` seconds when given.
        """
        inputs = [self._spring, self.depth, self._start.depth, self._damping_over_step(step)]
        wp.launch(self._kernels.energy, self.shape[1], inputs, [self._energy], device=self.device)
        return self._energy.numpy()
