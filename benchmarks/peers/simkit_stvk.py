"""simkit: its StVK, backward Euler and Newton solver, in full space and dense in Lingual's subspace.

full: sparse Newton with SciPy's direct solver on the free nodes. reduced: simkit's element energy, stress and Hessian
with dense products around them, in the basis and with the cubature of Lingual's reduced model, the positions of all
nodes included. simkit stops by the length of its last Newton step, not by a residual; the lengths are set so that it
reaches the residual asked for.
"""

from collections.abc import Callable
from dataclasses import dataclass
from importlib.metadata import version

import numpy as np
import scipy.sparse as sp
from simkit import deformation_jacobian, massmatrix, volume
from simkit.energies import stvk
from simkit.integrators import backward_euler
from step_problem import Participation, StepProblem, arguments, run

MAXIMUM_ITERATIONS = 10
STEP_LENGTH = {"full": 1e-6, "reduced": 1e-8}
"""Length of the last Newton step at which simkit stops: [m] over all nodes; of mass-orthonormal coordinates."""


@dataclass(frozen=True, eq=False)
class Potential:
    """Elastic energy, its gradient and Hessian in the unknown z, (unknowns, 1), and the mass on z.

    force: gravity on z, (unknowns, 1). displacement: of all nodes [m], (node_count, 3), from z.
    """

    energy: Callable[[np.ndarray], float]
    gradient: Callable[[np.ndarray], np.ndarray]
    hessian: Callable[[np.ndarray], object]
    mass: object
    force: np.ndarray
    displacement: Callable[[np.ndarray], np.ndarray]


def _full(problem: StepProblem) -> Potential:
    """On the free nodes, by simkit's assembled functions."""
    free = (3 * problem.free[:, None] + np.arange(3)).ravel()
    embedding = sp.identity(3 * len(problem.nodes), format="csc")[:, free]
    M = sp.kron(massmatrix(problem.nodes, problem.tets, rho=problem.density), sp.identity(3)).tocsc()
    J = deformation_jacobian(problem.nodes, problem.tets).tocsc() @ embedding
    count = len(problem.tets)
    mu, lam = np.full((count, 1), problem.lame_mu), np.full((count, 1), problem.lame_lambda)
    material = (J, np.tile(np.eye(3).reshape(-1, 1), (count, 1)), mu, lam, volume(problem.nodes, problem.tets))
    return Potential(
        lambda z: stvk.stvk_energy_u(z.reshape(-1, 3), *material),
        lambda z: stvk.stvk_gradient_u(z.reshape(-1, 3), *material),
        lambda z: stvk.stvk_hessian_u(z.reshape(-1, 3), *material, psd=False),
        M[free][:, free],
        (M @ np.tile(problem.gravity, len(problem.nodes)))[free].reshape(-1, 1),
        lambda z: (embedding @ z).reshape(-1, 3),
    )


def _reduced(problem: StepProblem) -> Potential:
    """On the reduced coordinates, by simkit's element functions and dense products."""
    count, B = len(problem.cubature_elements), problem.basis
    rows = (9 * problem.cubature_elements[:, None] + np.arange(9)).ravel()
    J = deformation_jacobian(problem.nodes, problem.tets).tocsr()[rows] @ np.kron(B, np.eye(3))
    by_element = np.ascontiguousarray(J.reshape(count, 9, -1))
    mu, lam = np.full((count, 1), problem.lame_mu), np.full((count, 1), problem.lame_lambda)
    weights = problem.cubature_weights.reshape(-1, 1)

    def F(z: np.ndarray) -> np.ndarray:
        return np.eye(3) + (J @ z).reshape(-1, 3, 3)

    def gradient(z: np.ndarray) -> np.ndarray:
        return J.T @ (weights[:, None] * stvk.stvk_gradient_element_F(F(z), mu, lam)).reshape(-1, 1)

    def hessian(z: np.ndarray) -> np.ndarray:
        blocks = weights[:, None] * stvk.stvk_hessian_element_F(F(z), mu, lam)
        return J.T @ (blocks @ by_element).reshape(9 * count, -1)

    masses = massmatrix(problem.nodes, problem.tets, rho=problem.density).diagonal()
    return Potential(
        lambda z: float((weights * stvk.stvk_energy_element_F(F(z), mu, lam)).sum()),
        gradient,
        hessian,
        np.kron(B.T @ (masses[:, None] * B), np.eye(3)),
        (B.T @ (masses[:, None] * problem.gravity)).reshape(-1, 1),
        lambda z: B @ z.reshape(-1, 3),
    )


class Stepper:
    """Backward Euler steps by simkit's integrator from rest, with the displacement of all nodes."""

    def __init__(self, problem: StepProblem, potential: Potential, step_length: float) -> None:
        self.problem, self.potential, self.step_length = problem, potential, step_length
        self.z = self.previous = np.zeros_like(potential.force)
        self.iterations = 0
        self.displacement = np.zeros_like(problem.nodes)

    def advance(self) -> None:
        potential = self.potential
        z, information = backward_euler(
            self.z,
            self.previous,
            lambda z: potential.energy(z) - float((potential.force * z).sum()),
            lambda z: potential.gradient(z) - potential.force,
            potential.hessian,
            potential.mass,
            self.problem.step,
            tolerance=self.step_length,
            max_iter=MAXIMUM_ITERATIONS,
            return_info=True,
        )
        self.iterations = information["iters"] + 1
        self.previous, self.z = self.z, z
        self.displacement = potential.displacement(z)


def main() -> None:
    problem, result, variant = arguments()
    full = variant == "full"
    potential = _full(problem) if full else _reduced(problem)
    stepper = Stepper(problem, potential, STEP_LENGTH[variant])
    participation = Participation(
        "simkit, full space" if full else "simkit, dense reduced",
        f"simkit {version('simkit')}, SciPy {version('scipy')}",
        "stvk",
        1,
        len(potential.force),
        "same equations; SciPy's SuperLU; stops by step length"
        if full
        else "Lingual's basis and cubature, simkit's element terms and Newton, dense float64; stops by step length",
        reduced=not full,
    )
    run(
        problem, result, participation, stepper.advance,
        lambda: problem.nodes + stepper.displacement, lambda: {"iterations": stepper.iterations},
    )  # fmt: skip


if __name__ == "__main__":
    main()
