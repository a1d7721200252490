"""Contact of every free boundary node with the rigid mouth, as a term of the full-space solver."""

import numpy as np
from numpy.typing import NDArray

from ..model import Control, TongueModel
from ..model.contact_forces import DAMPING, STIFFNESS, ContactForces
from ..model.signed_distance import SignedDistanceGrid


class NodalContact:
    """Damped springs at all free nodes of the tongue's boundary (a nodal_terms.NodalTerm): the reference that
    selected collision points are held to.

    grids: of the rigid parts. stiffness [Pa/m] and damping [s] as for ContactForces. The jaw is taken to come from
    where the step before had it.
    """

    def __init__(
        self,
        tongue: TongueModel,
        grids: tuple[SignedDistanceGrid, ...],
        stiffness: float = STIFFNESS,
        damping: float = DAMPING,
    ) -> None:
        self.nodes = np.setdiff1d(tongue.mesh.boundary_nodes, tongue.fixed_nodes)
        areas = tongue.mesh.boundary_areas[self.nodes]
        self.forces = ContactForces(tongue.mesh.nodes[self.nodes], areas, grids, stiffness, damping)
        self._displacement = self.forces.displacement.numpy()[:, :, 0]
        self._force = self.forces.force.numpy()[:, :, 0]
        self._dt = 0.0

    def begin_step(self, displacement: NDArray[np.float64], control: Control, dt: float) -> None:
        """Takes the start of a step."""
        self._dt = dt
        self.forces.displacement_start.numpy()[:, :, 0] = displacement
        self.forces.poses_start.copy_from(self.forces.poses)
        self.forces.poses.assign(control.jaw_pose)
        self.forces.begin_step()

    def force(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Gradient of the springs' incremental potential [N], (count, 3)."""
        self._displacement[:] = displacement
        self.forces.evaluate(self._dt)
        return self._force

    def stiffness(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Its Gauss-Newton derivative [N/m], (count, 3, 3)."""
        self.force(displacement)
        xx, xy, xz, yy, yz, zz = self.forces.stiffness.numpy()[:, :, 0].T
        return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]).transpose(2, 0, 1)
