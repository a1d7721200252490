"""MuJoCo: a 3D flex, integrated by its `discrete` scheme, which is implicit in position.

full-N: three translations at every node, StVK on the same tetrahedra with the same lumped masses. MuJoCo linearises
each step once, with a positive semi-definite stiffness, and solves by at most N block-preconditioned conjugate
gradients; without constraints its CG and Newton solvers do the same. quadratic-N: the tongue embedded in a few
quadratic box cells, another model, whose control nodes are pinned where clamped tissue is in their reach.
"""

from importlib.metadata import version

import mujoco
import numpy as np
from step_problem import Participation, StepProblem, arguments, run

CELLS = (3, 1, 1)
PINNED_SHARE = 0.05
"""Share of clamped nodes among those nearest to a control node from which on it is pinned. 150 degrees of freedom
remain on Lingual's own heads; with fewer pins the tongue tears off its roots and sags several times too far."""
RADIUS = 1e-4
"""Of a flex's vertices for contact [m]; there is no contact here."""


def _numbers(values: np.ndarray) -> str:
    return " ".join(f"{value:.12g}" for value in np.ravel(values))


def _control_nodes(problem: StepProblem) -> np.ndarray:
    """Control nodes of the quadratic cells, z fastest, (count, 3) [m]."""
    low, high = problem.nodes.min(axis=0), problem.nodes.max(axis=0)
    axes = [np.linspace(low[i], high[i], 2 * CELLS[i] + 1) for i in range(3)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)


def _pinned(problem: StepProblem, quadratic: bool) -> np.ndarray:
    """Indices of flex points, or of control nodes, that do not move."""
    if not quadratic:
        return problem.fixed
    control = _control_nodes(problem)
    nearest = ((problem.nodes[:, None] - control[None]) ** 2).sum(axis=2).argmin(axis=1)
    clamped = np.isin(np.arange(len(problem.nodes)), problem.fixed)
    near = np.bincount(nearest, minlength=len(control))
    share = np.bincount(nearest, clamped, minlength=len(control)) / np.maximum(near, 1)
    return np.flatnonzero(share >= PINNED_SHARE)


def _xml(problem: StepProblem, quadratic: bool, iterations: int) -> str:
    mass = float(problem.node_masses.sum())
    cells = f'dof="quadratic" cellcount="{_numbers(np.array(CELLS))}"' if quadratic else 'dof="full"'
    return f"""
<mujoco>
  <option timestep="{problem.step}" gravity="{_numbers(problem.gravity)}" integrator="discrete"
          iterations="{iterations}" tolerance="{problem.tolerance}"><flag contact="disable"/></option>
  <size memory="2G"/>
  <worldbody>
    <flexcomp name="tongue" type="direct" dim="3" {cells} mass="{mass}" radius="{RADIUS}"
              point="{_numbers(problem.nodes)}" element="{_numbers(problem.tets)}">
      <contact selfcollide="none" contype="0" conaffinity="0"/>
      <elasticity young="{problem.young_modulus}" poisson="{problem.poisson_ratio}" damping="0"/>
      <pin id="{_numbers(_pinned(problem, quadratic))}"/>
    </flexcomp>
  </worldbody>
</mujoco>"""


def _model(problem: StepProblem, quadratic: bool, iterations: int) -> mujoco.MjModel:
    model = mujoco.MjModel.from_xml_string(_xml(problem, quadratic, iterations))
    if not quadratic:  # flexcomp gives every node the same mass; the body of a free node carries its lumped mass
        bodies = model.flex_vertbodyid[problem.free]
        ratio = problem.node_masses[problem.free] / model.body_mass[bodies]
        model.body_mass[bodies] *= ratio
        model.body_inertia[bodies] *= ratio[:, None]
        mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


def main() -> None:
    problem, result, variant = arguments()
    kind, iterations = variant.split("-")
    quadratic = kind == "quadratic"
    model = _model(problem, quadratic, int(iterations))
    data = mujoco.MjData(model)

    def positions() -> np.ndarray:
        mujoco.mj_kinematics(model, data)  # mj_step leaves the positions of the step's start behind
        mujoco.mj_flex(model, data)
        return data.flexvert_xpos

    note = (
        f"{' x '.join(map(str, CELLS))} quadratic boxes around the tongue: another model, clamped at control nodes"
        if quadratic
        else "StVK on the same mesh and masses; one linearisation a step, no residual"
    )
    name = f"MuJoCo flex, {'quadratic cells' if quadratic else 'full'}, {iterations} iterations"
    law = "mujoco-cells" if quadratic else "stvk"
    participation = Participation(name, f"MuJoCo {version('mujoco')}", law, 1, int(model.nv), note, quadratic)
    # The linear solve of a step has no figure that can be read; a step that it did not solve counts as a warning.
    unsolved = mujoco.mjtWarning.mjWARN_INERTIA
    run(
        problem, result, participation, lambda: mujoco.mj_step(model, data), positions,
        lambda: {"unsolved_steps": int(data.warning[unsolved].number)},
    )  # fmt: skip


if __name__ == "__main__":
    main()
