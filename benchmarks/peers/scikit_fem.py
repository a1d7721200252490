"""scikit-fem: StVK assembled by its forms, Newton's method, MKL's sparse direct solver on one thread.

Residual, tangent and mass are assembled with scikit-fem (P1 elements, one quadrature point, which is exact for them);
the Newton loop around them is written here, as scikit-fem leaves it to its users. The mass is lumped by row sums.
It stops at the same relative residual, in the norm dual to the mass, as Lingual.
"""

from importlib.metadata import version

import numpy as np
import scipy.sparse as sp
from pypardiso import PyPardisoSolver
from skfem import Basis, BilinearForm, ElementTetP1, ElementVector, LinearForm, MeshTet
from skfem.helpers import ddot, dot, eye, grad, mul, trace, transpose
from step_problem import Participation, StepProblem, arguments, run

MAXIMUM_ITERATIONS = 15
SYMMETRIC_INDEFINITE = -2
"""Pardiso's matrix type: the StVK tangent under compression need not be definite."""


def _strain_terms(gradient: np.ndarray, mu: float, lam: float) -> dict[str, np.ndarray]:
    """F and the second Piola-Kirchhoff stress S [Pa] at the quadrature points, from the displacement's gradient."""
    identity = eye(np.ones(gradient.shape[2:]), 3)
    F = gradient + identity
    E = 0.5 * (mul(transpose(F), F) - identity)
    return {"F": F, "S": 2.0 * mu * E + lam * eye(trace(E), 3)}


def _forms(mu: float, lam: float) -> tuple[LinearForm, BilinearForm]:
    """Internal force and tangent of StVK, given F and S, which a form would else compute for every pair of bases."""

    @LinearForm
    def internal_force(v, w):
        return ddot(mul(w["F"], w["S"]), grad(v))

    @BilinearForm
    def tangent(u, v, w):
        half = mul(transpose(w["F"]), grad(u))
        dE = 0.5 * (half + transpose(half))
        dS = 2.0 * mu * dE + lam * eye(trace(dE), 3)
        return ddot(mul(grad(u), w["S"]) + mul(w["F"], dS), grad(v))

    return internal_force, tangent


class NewtonStepper:
    """Implicit Euler steps of the displacement u, (dof_count,) [m] in scikit-fem's order, 3 node + component."""

    def __init__(self, problem: StepProblem) -> None:
        mesh = MeshTet(problem.nodes.T.copy(), problem.tets.T.copy())
        self.problem = problem
        self.basis = Basis(mesh, ElementVector(ElementTetP1()), intorder=1)
        self.internal_force, self.tangent = _forms(problem.lame_mu, problem.lame_lambda)
        consistent = BilinearForm(lambda u, v, w: dot(u, v)).assemble(Basis(mesh, ElementVector(ElementTetP1())))
        self.mass = problem.density * np.asarray(consistent.sum(axis=1)).ravel()
        self.dofs = self.basis.nodal_dofs.T  # (node_count, 3)
        self.free = np.sort(self.dofs[problem.free].ravel())
        self.weight = np.zeros(self.basis.N)
        self.weight[self.dofs] = problem.gravity * self.mass[self.dofs]
        self.u, self.velocity = np.zeros(self.basis.N), np.zeros(self.basis.N)
        self.pardiso = PyPardisoSolver(mtype=SYMMETRIC_INDEFINITE)
        self.iterations, self.residual = 0, np.inf

    def advance(self) -> None:
        h, free, mass = self.problem.step, self.free, self.mass
        predicted = self.u + h * self.velocity
        u = predicted.copy()
        for iteration in range(MAXIMUM_ITERATIONS + 1):
            self.iterations = iteration
            at = _strain_terms(self.basis.interpolate(u).grad, self.problem.lame_mu, self.problem.lame_lambda)
            terms = [mass * (u - predicted) / h**2, self.internal_force.assemble(self.basis, **at), -self.weight]
            residual = sum(terms)[free]
            dual = [np.linalg.norm(term[free] / np.sqrt(mass[free])) for term in terms]
            self.residual = float(np.linalg.norm(residual / np.sqrt(mass[free])) / max(dual))
            if self.residual <= self.problem.tolerance:
                break
            K = self.tangent.assemble(self.basis, **at) + sp.diags_array(mass / h**2)
            upper = sp.csr_matrix(sp.triu(K.tocsr()[free][:, free]))
            u[free] -= self.pardiso.solve(upper, residual)
        self.velocity = (u - self.u) / h
        self.u = u

    def positions(self) -> np.ndarray:
        return self.problem.nodes + self.u[self.dofs]


def main() -> None:
    problem, result, _ = arguments()
    stepper = NewtonStepper(problem)
    participation = Participation(
        "scikit-fem, Pardiso",
        f"scikit-fem {version('scikit-fem')}, pypardiso {version('pypardiso')}",
        "stvk",
        1,
        len(stepper.free),
        "same equations, same tolerance; assembled by scikit-fem, Newton loop ours, MKL Pardiso",
    )
    reported = lambda: {"iterations": stepper.iterations, "residual": stepper.residual}  # noqa: E731
    run(problem, result, participation, stepper.advance, stepper.positions, reported)


if __name__ == "__main__":
    main()
