"""Lingual's own solvers on the peers' problem, as one more participant, and the references that positions are held to.

full: SolverFullSpace at the problem's tolerance. reduced: TongueBatch, one tongue in float32, positions of all nodes
included. reference-LAW: SolverFullSpace of that law at 1e-8. All without Rayleigh damping, sensors, contact and volume
correction, which the peers do not have.
"""

from dataclasses import replace
from importlib.metadata import version

import numpy as np
from step_problem import Participation, StepProblem, arguments, run
from threadpoolctl import threadpool_limits

from lingual.app.solver_options import SolverOptions
from lingual.app.wiring import reduced_model
from lingual.model import Control, Material, TongueModel
from lingual.precompute.meshes.library import load_tongue
from lingual.solver.full_space import SolverFullSpace
from lingual.solver.tongue_batch import TongueBatch

REFERENCE_TOLERANCE = 1e-8
REFERENCE = "reference-"


def undamped(problem: StepProblem, law: str) -> Material:
    return Material(
        law, problem.young_modulus, problem.poisson_ratio, problem.density, damping_mass=0.0, damping_stiffness=0.0
    )


class FullSpaceStepper:
    """Steps of SolverFullSpace under gravity, all sensors free."""

    def __init__(self, problem: StepProblem, tongue: TongueModel, law: str, tolerance: float) -> None:
        self.solver = SolverFullSpace(replace(tongue, material=undamped(problem, law)), tolerance)
        self.states = [self.solver.new_state(), self.solver.new_state()]
        rest = tongue.sensor_rest_positions
        self.control = Control(rest.copy(), np.zeros(rest.shape, dtype=bool), problem.gravity)
        self.step = problem.step

    def advance(self) -> None:
        self.solver.step(self.states[0], self.states[1], self.control, self.step)
        self.states.reverse()

    def positions(self) -> np.ndarray:
        return self.states[0].position.numpy()

    def reported(self) -> dict[str, float]:
        return {"iterations": self.solver.report.iterations, "residual": self.solver.report.residual}


class ReducedStepper:
    """Steps of one tongue of a TongueBatch under gravity, all sensors free."""

    def __init__(self, problem: StepProblem, tongue: TongueModel) -> None:
        # The subspace is that of the damped tongue, as it is cached; its material is exchanged afterwards.
        model = reduced_model(tongue, SolverOptions())
        model = replace(model, tongue=replace(tongue, material=undamped(problem, "stvk")))
        free = np.zeros(tongue.sensor_rest_positions.shape, dtype=bool)
        self.batch = TongueBatch(model, free, problem.step, 1, "float32", "cpu", problem.tolerance)
        self.batch.set_gravity(problem.gravity)

    def advance(self) -> None:
        self.batch.step()

    def positions(self) -> np.ndarray:
        return self.batch.position.numpy()[:, :, 0]

    def reported(self) -> dict[str, float]:
        return {"iterations": self.batch.evaluations, "residual": float(self.batch.errors[0])}


def main() -> None:
    problem, result, variant = arguments()
    tongue = load_tongue(problem.mesh or None)
    if variant == "reduced":
        stepper: FullSpaceStepper | ReducedStepper = ReducedStepper(problem, tongue)
        name, law, dofs = "Lingual reduced", "stvk", stepper.batch.model.dof_count
        note = f"{len(stepper.batch.model.cubature_elements)} cubature elements, float32"
    else:
        law = variant.removeprefix(REFERENCE) if variant.startswith(REFERENCE) else "stvk"
        tolerance = REFERENCE_TOLERANCE if variant.startswith(REFERENCE) else problem.tolerance
        stepper = FullSpaceStepper(problem, tongue, law, tolerance)
        name, dofs, note = "Lingual full space", stepper.solver.dof_count, f"relative residual {tolerance:g}"
    participation = Participation(name, f"lingual {version('lingual')}", law, 1, dofs, note, variant == "reduced")
    with threadpool_limits(limits=1, user_api="blas"):
        run(problem, result, participation, stepper.advance, stepper.positions, stepper.reported)


if __name__ == "__main__":
    main()
