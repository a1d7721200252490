"""SolverFullSpace: implicit Euler on every free node, the reference that reduced solvers are held to."""

import numpy as np
import scipy.sparse as sp
import warp as wp
from numpy.typing import NDArray

from ..model import Control, State, TongueModel
from ..model.multifrontal import MultifrontalCholesky
from . import newton
from .full_space_device import DeviceStep
from .full_space_step import FullSpaceStep
from .lbfgs import LaggedBfgs
from .nodal_terms import NodalTerm
from .projected_cg import LaggedPreconditioner, Solve, projected_cg
from .protocol import StepReport


class SolverFullSpace:
    """Implicit steps on 3 unknowns a free node, sensors by Lagrange multipliers.

    tongue: what is simulated. tolerance: relative residual in the mass norm, as for the reduced solver.
    terms: further forces on nodes, contact for one. device: of the states.
    method: "factor", on the CPU: limited-memory BFGS with a single-precision factor of an earlier tangent; a step that
    this does not solve, by Newton's method. "conjugate-gradients", on any device: Newton's method with conjugate
    gradients. By default the one that suits the device.
    """

    name = "full"
    volume_mode = "none"

    def __init__(
        self,
        tongue: TongueModel,
        tolerance: float = newton.TOLERANCE,
        terms: tuple[NodalTerm, ...] = (),
        device: str = "cpu",
        method: str | None = None,
    ) -> None:
        self.tongue = tongue
        self._terms = terms
        self.report = StepReport()
        self.tolerance = tolerance
        self.device = device
        if method is None:
            method = "factor" if device == "cpu" else "conjugate-gradients"
        self._bfgs = LaggedBfgs() if method == "factor" else None
        self._problem = _FactoredStep(tongue, terms) if method == "factor" else DeviceStep(tongue, terms, device)

    @property
    def contact_point_count(self) -> int:
        return sum(len(term.nodes) for term in self._terms)

    @property
    def dof_count(self) -> int:
        return 3 * len(self.tongue.free_nodes)

    def new_state(self) -> State:
        def zeros(count: int) -> wp.array:
            return wp.zeros(count, dtype=wp.vec3d, device=self.device)

        return State(
            time=0.0,
            position=wp.array(self.tongue.mesh.nodes, dtype=wp.vec3d, device=self.device),
            velocity=zeros(self.tongue.mesh.node_count),
            coordinates=zeros(0),
            coordinate_velocity=zeros(0),
            sensor_force=zeros(self.tongue.sensors.count),
        )

    def step(self, state_in: State, state_out: State, control: Control, dt: float) -> None:
        free, rest = self.tongue.free_nodes, self.tongue.mesh.nodes
        start = (state_in.position.numpy() - rest)[free]
        velocity = state_in.velocity.numpy()[free]
        self._problem.begin(start, velocity, control, dt)
        with np.errstate(all="ignore"):  # a trial that diverges is refused, and reported when nothing else is left
            x, multipliers = self._solve(start.ravel(), velocity.ravel() * dt)
        displacement = x.reshape(-1, 3)
        nodal = np.zeros_like(rest)
        nodal[free] = displacement
        state_out.position.assign(rest + nodal)
        nodal[free] = (displacement - start) / dt
        state_out.velocity.assign(nodal)
        state_out.sensor_force.assign(self._problem.constraints.forces(multipliers))
        state_out.time = state_in.time + dt

    def _solve(self, start: NDArray, advance: NDArray) -> tuple[NDArray, NDArray]:
        """Displacement at the end of the step and multipliers; `advance` is how far the velocity carries."""
        if self._bfgs is not None:
            assert isinstance(self._problem, _FactoredStep)
            try:
                result = self._bfgs.solve_step(self._problem, start + advance, self.report, self.tolerance)
                if self.report.converged:
                    return result
            except np.linalg.LinAlgError:
                pass  # repeated constraints, or no factor to start with
            self._bfgs.forget()
        return newton.solve_step(self._problem, start.copy(), self.report, self.tolerance)


class _FactoredStep(FullSpaceStep):
    """A step whose tangents are factorised on the host (an lbfgs.FactoredStep)."""

    def __init__(self, tongue: TongueModel, terms: tuple[NodalTerm, ...]) -> None:
        super().__init__(tongue, terms)
        self._preconditioner = LaggedPreconditioner()
        pattern = self._discretisation.pattern
        self._factor = MultifrontalCholesky(tongue.mesh.nodes[self._free], pattern.row_starts, pattern.columns)

    def begin(self, start: NDArray, velocity: NDArray, control: Control, dt: float) -> None:
        super().begin(start, velocity, control, dt)
        self._preconditioner.begin_step(dt, self._constraints_changed)

    def precondition(self, force: NDArray, gap: NDArray) -> tuple[NDArray, NDArray]:
        return self._preconditioner.solve(self.constraints.rows, force, gap)

    @property
    def ready(self) -> bool:
        return self._preconditioner.ready

    def renew(self, x: NDArray) -> None:
        """Factorises the tangent at x, which the last residual was evaluated at, or a definite one where it is not."""
        try:
            solve = self._factorised(self._tangent(x, definite=False))
        except np.linalg.LinAlgError:
            solve = self._factorised(self._tangent(x, definite=True))
        self._preconditioner.renew(solve, self.constraints.rows)

    def _tangent(self, x: NDArray, definite: bool) -> sp.bsr_array:
        """Derivative of the residual at x, which the last residual was evaluated at."""
        A = self._discretisation.stiffness(self._dt, definite)
        A.data[self._diagonal_blocks] += self._tangent_diagonal(x)
        return A

    def _factorised(self, A: sp.bsr_array) -> Solve:
        self._factor.factorise(A.data)
        return self._factor.solve

    def newton_step(self, x: NDArray, residual: NDArray, gap: NDArray) -> tuple[NDArray, NDArray]:
        try:
            return self._solve_linear(self._tangent(x, definite=False), residual, gap)
        except np.linalg.LinAlgError:
            return self._solve_linear(self._tangent(x, definite=True), residual, gap)

    def _solve_linear(self, A: sp.bsr_array, residual: NDArray, gap: NDArray) -> tuple[NDArray, NDArray]:
        return projected_cg(
            A.__matmul__, lambda: self._factorised(A), self.constraints.rows, -residual, gap, self._preconditioner
        )
