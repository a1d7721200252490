"""The equations of one full-space step, whatever solves them."""

import numpy as np
from numpy.typing import NDArray

from ..model import Control, TongueModel
from ..model.discretisation import Discretisation
from . import newton
from .constraints import SensorConstraints
from .nodal_terms import NodalTerm, NodalTerms


class FullSpaceStep:
    """Residual, constraints and tangent of one step; unknowns are the displacements of the free nodes, flat.

    terms: forces beside the elastic ones. device: where elements are evaluated; vectors are the host's.
    """

    def __init__(self, tongue: TongueModel, terms: tuple[NodalTerm, ...] = (), device: str = "cpu") -> None:
        self._free = tongue.free_nodes
        self._discretisation = Discretisation(tongue.mesh, tongue.material, self._free, device=device)
        self._terms = NodalTerms(terms, self._free)
        self._nodal = np.zeros_like(tongue.mesh.nodes)
        self._mass = np.repeat(tongue.node_masses[self._free], 3)
        self._damping_mass = tongue.material.damping_mass
        self.constraints = SensorConstraints(tongue, tongue.sensors.weights[:, self._free].toarray())
        pattern = self._discretisation.pattern
        rows = np.repeat(np.arange(len(self._free)), np.diff(pattern.row_starts))
        self._diagonal_blocks = np.flatnonzero(rows == pattern.columns)

    def _set(self, x: NDArray) -> None:
        self._nodal[self._free] = x.reshape(-1, 3)
        self._discretisation.set_displacement(self._nodal)

    def begin(self, start: NDArray, velocity: NDArray, control: Control, dt: float) -> None:
        """Fixes the data of one step; the damping refers to the start's displacement gradients."""
        self._constraints_changed = self.constraints.set_control(control)
        self._dt = dt
        self._scale = newton.smallest_scale(float(self._mass[::3].sum()), dt)
        self._start = start.ravel()
        self._velocity = velocity.ravel()
        self._load = self._mass * np.tile(control.gravity, len(self._free))
        self._set(start)
        self._discretisation.elements.begin_step()
        self._terms.begin_step(start, control, dt)

    def residual(self, x: NDArray) -> tuple[NDArray, float]:
        self._set(x)
        rate = (x - self._start) / self._dt
        inertia = self._mass * (rate - self._velocity) / self._dt
        internal = self._discretisation.internal_force(self._dt)[self._free]
        self._terms.add_force(x.reshape(-1, 3), internal)
        internal = internal.ravel()
        residual = inertia + self._damping_mass * self._mass * rate + internal - self._load
        return residual, max(self._norm(inertia), self._norm(internal), self._scale)

    def gap(self, x: NDArray) -> NDArray:
        return self.constraints.target - self.constraints.rows @ x

    def constraint_force(self, multipliers: NDArray) -> NDArray:
        return self.constraints.rows.T @ multipliers

    def _tangent_diagonal(self, x: NDArray) -> NDArray[np.float64]:
        """What inertia, damping and the nodal terms add to the tangent's diagonal blocks at x, (free, 3, 3)."""
        shift = self._mass[::3] * (1.0 / self._dt**2 + self._damping_mass / self._dt)
        return self._terms.stiffness(x.reshape(-1, 3)) + shift[:, None, None] * np.eye(3)

    def dual_norm(self, residual: NDArray, multipliers: NDArray) -> float:
        return self._norm(residual + self.constraint_force(multipliers))

    def _norm(self, force: NDArray) -> float:
        return float(np.sqrt(np.sum(force**2 / self._mass)))
