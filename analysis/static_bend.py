"""Static bends under a dead load, in full space or in a subspace, as studies of subspaces compare them.

Both minimise the potential W(u) - f.u over u = T x, with T the identity on the free nodes or B (x) I_3, by
Newton's method with a backtracking line search; all elements are integrated, so a difference between the
two is the subspace's alone. As a subspace holds fewer shapes, its least potential is never below the full one.
"""

from dataclasses import dataclass

import numpy as np
import scipy.linalg
import scipy.sparse as sp
from numpy.typing import NDArray

from ..model import LingualError, TongueModel
from ..model.discretisation import Discretisation
from ..model.sparse_factor import factorise

TOLERANCE = 1e-8
"""Residual relative to the load at which an equilibrium is accepted."""
MAXIMUM_ITERATIONS = 100
SUFFICIENT_DECREASE = 1e-4
SMALLEST_STEP = 1e-6


@dataclass(frozen=True, eq=False)
class Bend:
    """A body and the load that bends it.

    name: how reports call it. tongue: the body. load: dead load [N], (node_count, 3). tip_nodes: indices of
    the nodes whose mean displacement is the tip's.
    """

    name: str
    tongue: TongueModel
    load: NDArray[np.float64]
    tip_nodes: NDArray[np.int64]

    def tip_displacement(self, displacement: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mean displacement of the tip's nodes [m], (3,)."""
        return displacement[self.tip_nodes].mean(axis=0)


@dataclass(frozen=True, eq=False)
class Equilibrium:
    """A bent body at rest.

    displacement: (node_count, 3) [m]. potential: W - f.u [J], negative. det_f_min: smallest over the elements.
    converged: whether the residual is below TOLERANCE. iterations: of Newton's method.
    """

    displacement: NDArray[np.float64]
    potential: float
    det_f_min: float
    converged: bool
    iterations: int


def scaled_bend(
    name: str, tongue: TongueModel, load: NDArray[np.float64], tip_nodes: NDArray[np.int64], reach: float
) -> Bend:
    """The load scaled such that linear elasticity would move the tip by `reach` [m]."""
    unit = Bend(name, tongue, load, tip_nodes)
    statics = _Statics(unit, None)
    statics.set_unknowns(np.zeros(statics.size))
    linear = statics.displacement(statics.newton_step(statics.gradient()))
    moved = float(np.linalg.norm(unit.tip_displacement(linear)))
    if not moved > 0.0:
        raise LingualError(f"The load does not move the tip of '{name}': check its fixed nodes and its sensors.")
    return Bend(name, tongue, load * (reach / moved), tip_nodes)


def bent(bend: Bend, basis: NDArray[np.float64] | None = None) -> Equilibrium:
    """The equilibrium in full space, or in the subspace of `basis` B (node_count, columns), zero at fixed nodes."""
    statics = _Statics(bend, basis)
    x = np.zeros(statics.size)
    potential = statics.set_unknowns(x)
    load_norm = float(np.linalg.norm(statics.load))
    converged = False
    for iteration in range(MAXIMUM_ITERATIONS + 1):
        gradient = statics.gradient()
        converged = bool(np.linalg.norm(gradient) <= TOLERANCE * load_norm)
        if converged or iteration == MAXIMUM_ITERATIONS:
            break
        step = statics.newton_step(gradient)
        advanced = _search(statics, x, step, float(gradient @ step), potential)
        if advanced is None:
            break
        x, potential = advanced
    return Equilibrium(statics.displacement(x), potential, statics.det_f_min(), converged, iteration)


def _search(
    statics: "_Statics", x: NDArray[np.float64], step: NDArray[np.float64], slope: float, potential: float
) -> tuple[NDArray[np.float64], float] | None:
    """The longest of 1, 1/2, ... steps that lowers the potential enough, and the potential there; None for none.

    Where the tangent is indefinite the step may lead uphill; it is then taken backwards.
    """
    if slope > 0.0:
        step, slope = -step, -slope
    rounding = 1e-12 * abs(potential)
    length = 1.0
    while length > SMALLEST_STEP:
        trial = x + length * step
        value = statics.set_unknowns(trial)
        if value <= potential + SUFFICIENT_DECREASE * length * slope + rounding:
            return trial, value
        length *= 0.5
    statics.set_unknowns(x)
    return None


class _Statics:
    """Potential, gradient and Newton step of one bend in its unknowns x, (size,)."""

    def __init__(self, bend: Bend, basis: NDArray[np.float64] | None) -> None:
        tongue = bend.tongue
        self._free = tongue.free_nodes
        self._mesh = tongue.mesh
        self._discretisation = Discretisation(tongue.mesh, tongue.material, self._free)
        self._motion = None if basis is None else np.kron(basis[self._free], np.eye(3))
        self._nodal_load = bend.load
        self.load = self._restricted(bend.load)
        self.size = len(self.load)

    def _restricted(self, nodal: NDArray[np.floating]) -> NDArray[np.float64]:
        free = np.asarray(nodal[self._free], dtype=np.float64).ravel()
        return free if self._motion is None else self._motion.T @ free

    def displacement(self, x: NDArray[np.float64]) -> NDArray[np.float64]:
        """Nodal displacement (node_count, 3) [m]."""
        displacement = np.zeros_like(self._mesh.nodes)
        free = x if self._motion is None else self._motion @ x
        displacement[self._free] = free.reshape(-1, 3)
        return displacement

    def set_unknowns(self, x: NDArray[np.float64]) -> float:
        """Evaluates the body at x; its potential [J]."""
        displacement = self.displacement(x)
        self._discretisation.set_displacement(displacement)
        density, _ = self._discretisation.elements.energy_density()
        return float(density @ self._mesh.volumes - np.sum(self._nodal_load * displacement))

    def det_f_min(self) -> float:
        return float(self._discretisation.elements.energy_density()[1].min())

    def gradient(self) -> NDArray[np.float64]:
        return self._restricted(self._discretisation.internal_force()) - self.load

    def newton_step(self, gradient: NDArray[np.float64]) -> NDArray[np.float64]:
        stiffness: sp.csr_array = self._discretisation.stiffness().tocsr()
        if self._motion is None:
            return factorise(stiffness).solve(-gradient)
        return scipy.linalg.solve(self._motion.T @ (stiffness @ self._motion), -gradient, assume_a="sym")
