"""newton (newton-physics): its vertex block descent (VBD) and its XPBD, both on Warp in float32.

Both take tetrahedra; neither has a residual or a tolerance, only a number of iterations, which is the variant:
"vbd-100" for instance. VBD minimises the implicit Euler potential of a stable Neo-Hookean body one node at a time;
XPBD treats strain and volume as compliant constraints and sums the corrections of all elements at a node, which
diverges here unless they are relaxed far below the default of 0.9.
"""

from importlib.metadata import version

import newton
import warp as wp
from step_problem import Participation, StepProblem, arguments, run

XPBD_RELAXATION = 0.03
"""Share of an element's correction that is applied: the largest tried (0.9, 0.3, 0.1, 0.03) that stays bounded."""
LAWS = {"vbd": "neo-hookean", "xpbd": "xpbd"}


def _model(problem: StepProblem) -> newton.Model:
    builder = newton.ModelBuilder(gravity=tuple(float(g) for g in problem.gravity))
    builder.add_soft_mesh(
        pos=wp.vec3(0.0, 0.0, 0.0),
        rot=wp.quat_identity(),
        scale=1.0,
        vel=wp.vec3(0.0, 0.0, 0.0),
        vertices=[wp.vec3(*node) for node in problem.nodes],
        indices=problem.tets.ravel().tolist(),
        density=problem.density,
        k_mu=problem.lame_mu,
        k_lambda=problem.lame_lambda,
        k_damp=0.0,
        add_surface_mesh_edges=False,
        particle_radius=1e-4,
    )
    for node in problem.fixed:
        builder.particle_mass[node] = 0.0
        builder.particle_flags[node] = 0
    builder.color()
    return builder.finalize(device="cpu")


def _solver(model: newton.Model, kind: str, iterations: int) -> object:
    if kind == "vbd":
        return newton.solvers.SolverVBD(model, iterations=iterations, particle_enable_tile_solve=False)
    return newton.solvers.SolverXPBD(model, iterations=iterations, soft_body_relaxation=XPBD_RELAXATION)


def main() -> None:
    problem, result, variant = arguments()
    kind, iterations = variant.split("-")
    wp.config.quiet = True
    model = _model(problem)
    solver = _solver(model, kind, int(iterations))
    states = [model.state(), model.state()]
    control = model.control()

    def advance() -> None:
        states[0].clear_forces()
        solver.step(states[0], states[1], control, None, problem.step)
        states.reverse()

    participation = Participation(
        f"newton {kind.upper()}, {iterations} iterations",
        f"newton {version('newton')}, Warp {wp.__version__}",
        LAWS[kind],
        1,
        3 * len(problem.free),
        "no tolerance, iterations only; float32",
    )
    run(problem, result, participation, advance, lambda: states[0].particle_q.numpy())


if __name__ == "__main__":
    main()
