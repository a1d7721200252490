"""Limited-memory BFGS for implicit steps with linear constraints, on top of a factor of an earlier tangent.

Every iteration costs one residual and one solution with the factor; no tangent is assembled and no linear
system is iterated on. The step's potential is nearly quadratic, as its largest part, the viscosity, is exactly
so; what the factor has missed since it was made is learnt as pairs (change of x, change of residual), which
are kept from step to step (Nocedal and Wright 2006, algorithm 7.4; the lagged factor as its initial matrix is
Liu et al. 2017). The factor is applied in the constraints' null space, so after the first iteration every x
meets the targets.
"""

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .newton import StepProblem
from .protocol import StepReport

MEMORY = 40
"""Pairs kept. Each costs four passes over a vector; the factor's solution costs some hundred."""
PATIENCE = 10
"""Iterations after which the factor is renewed within the step if as many as it costs are still to come."""
MAXIMUM_ITERATIONS = 60
"""With one factor."""
FRESH_ITERATIONS = 4
"""What a step takes right after its tangent has been factorised."""
RENEWALS_IN_STEP = 2
FACTOR_COST = 16
"""Iterations that one new factor costs: it is made when the old one has wasted as many."""
DIVERGENCE = 10.0
"""A residual so many times the least one of the step means that a new factor is needed."""


class FactoredStep(StepProblem, Protocol):
    """A step's equations together with a factor of its tangent."""

    def precondition(self, force: NDArray, gap: NDArray) -> tuple[NDArray, NDArray]:
        """dx and multipliers y with P dx + J^T y = force and J dx = gap, P the factorised tangent."""
        ...

    def renew(self, x: NDArray) -> None:
        """Factorises the tangent at x. Raises numpy.linalg.LinAlgError when that is impossible."""
        ...

    @property
    def ready(self) -> bool:
        """Whether there is a factor that suits this step's constraints and duration."""
        ...

    def constraint_force(self, multipliers: NDArray) -> NDArray:
        """J^T multipliers."""
        ...


class Pairs:
    """The newest `MEMORY` pairs (s, y) and the product with the inverse matrix they define."""

    def __init__(self) -> None:
        self._pairs: list[tuple[NDArray, NDArray, float]] = []

    def __len__(self) -> int:
        return len(self._pairs)

    def forget(self) -> None:
        self._pairs.clear()

    def add(self, s: NDArray, y: NDArray) -> None:
        """Takes a pair unless the potential curved down along it."""
        curvature = float(s @ y)
        if curvature > 0.0:
            self._pairs.append((s, y, 1.0 / curvature))
            del self._pairs[:-MEMORY]

    def direction(self, problem: FactoredStep, force: NDArray, gap: NDArray) -> tuple[NDArray, NDArray]:
        """As `problem.precondition`, with what the pairs know."""
        force = force.copy()
        shares = []
        for s, y, inverse in reversed(self._pairs):
            share = inverse * float(s @ force)
            force -= share * y
            shares.append(share)
        dx, multipliers = problem.precondition(force, gap)
        for (s, y, inverse), share in zip(self._pairs, reversed(shares), strict=True):
            dx += (share - inverse * float(y @ dx)) * s
        return dx, multipliers


class LaggedBfgs:
    """Solves the steps of one problem one after the other, with what it has learnt from the earlier ones."""

    def __init__(self) -> None:
        self._pairs = Pairs()
        self._wasted = 0

    def forget(self) -> None:
        """Forgets the pairs and plans a new factor for the next step."""
        self._pairs.forget()
        self._wasted = FACTOR_COST

    def solve_step(
        self, problem: FactoredStep, x: NDArray, report: StepReport, tolerance: float
    ) -> tuple[NDArray, NDArray]:
        """x and multipliers, starting from x; `report` says whether they converged.

        Raises numpy.linalg.LinAlgError when the tangent cannot be factorised.
        """
        residual, _ = problem.residual(x)
        if not problem.ready or self._wasted >= FACTOR_COST:
            self._renew(problem, x)
        gap = problem.gap(x)
        multipliers = np.zeros_like(gap)
        report.converged, report.residual, report.iterations = False, np.inf, 0
        renewals = since_renewal = 0
        least = first = np.inf
        while True:
            report.iterations += 1
            since_renewal += 1
            force = -(residual + problem.constraint_force(multipliers))
            dx, change = self._pairs.direction(problem, force, gap)
            trial, wanted = x + dx, multipliers + change
            trial_residual, scale = problem.residual(trial)
            norm = problem.dual_norm(trial_residual, wanted)
            error = norm / scale
            if error <= tolerance:
                report.converged, report.residual = True, error
                self._wasted += max(0, since_renewal - FRESH_ITERATIONS)
                return trial, wanted
            feasible = not np.abs(gap).max(initial=0.0) > 1e-12
            diverges = not np.isfinite(error) or norm > DIVERGENCE * least
            first = error if since_renewal == 1 else first
            if diverges or _stale(since_renewal, first, error, tolerance):
                if renewals == RENEWALS_IN_STEP or not np.isfinite(error):
                    self.forget()
                    return trial, wanted
                renewals, since_renewal = renewals + 1, 0
                if diverges:
                    problem.residual(x)  # the tangent is to be that of the last good x
                else:
                    x, residual, multipliers, gap = trial, trial_residual, wanted, problem.gap(trial)
                self._renew(problem, x)
                continue
            if feasible:
                self._pairs.add(dx, trial_residual - residual)
            least = min(least, norm)
            x, residual, multipliers, report.residual = trial, trial_residual, wanted, error
            gap = problem.gap(x) if not feasible else gap

    def _renew(self, problem: FactoredStep, x: NDArray) -> None:
        self._pairs.forget()
        problem.renew(x)
        self._wasted = 0


def _stale(iterations: int, first: float, error: float, tolerance: float) -> bool:
    """Whether going on costs more than a new factor, by the mean rate since the error was `first`."""
    if iterations < PATIENCE:
        return False
    if iterations >= MAXIMUM_ITERATIONS or error >= first:
        return True
    rate = np.log(error / first) / (iterations - 1)
    return bool(np.log(tolerance / error) / rate > FACTOR_COST)
