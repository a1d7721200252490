"""Reduced solver against full space on one recording: speed as a ratio, distance of the surfaces in mm.

    python benchmarks/reduced_against_full.py --mesh PATH --recording FILE [--frames N] [--domains 5 8 12]
                                              [--cubature 300 600 1000 2000] [--json FILE]

One row for each number of domains, then one for each number of cubature elements at five domains, each without
and with volume correction. Both solvers run along the same frames in the same process; the reduced one as the command
line runs it, without contact. The distance is between corresponding surface nodes, over all frames.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from lingual.app.simulation import Simulation
from lingual.app.solver_options import TOLERANCES
from lingual.app.wiring import fitted_trajectory
from lingual.model import ReducedModel, Trajectory
from lingual.precompute.meshes.library import load_tongue
from lingual.precompute.pressure_subspace import build_pressure_subspace
from lingual.precompute.reduction import ReductionSettings, build_reduced_model
from lingual.solver.full_space import SolverFullSpace
from lingual.solver.reduced import SolverReduced

PRECISION = "float32"


def main() -> None:
    arguments = _arguments()
    tongue = load_tongue(arguments.mesh)
    trajectory = fitted_trajectory(arguments.recording, tongue).head(arguments.frames)
    full = _simulate(SolverFullSpace(tongue, TOLERANCES[PRECISION]), trajectory)
    full_nodes, full_ms = _surface(full), float(np.median(full.history.scalar("step_ms")))
    print(f"{tongue.name}: {tongue.mesh.node_count} nodes, {tongue.mesh.tet_count} tets, {len(full_nodes)} frames")
    print(f"full space: {full_ms:.1f} ms a step, {len(full.unconverged_frames)} frames not converged")
    print("domains  DOFs  cubature  force error  volume    ms/step  full/reduced  mean mm  max mm")
    settings = [ReductionSettings(domain_count=count) for count in arguments.domains]
    # A tolerance that is never met, so that the asked number of elements is used.
    settings += [ReductionSettings(cubature_per_domain=n // 5, cubature_tolerance=1e-6) for n in arguments.cubature]
    rows = []
    for setting in settings:
        model = build_reduced_model(tongue, setting)
        for volume in ("none", "subspace"):
            rows.append(_row(model, trajectory, volume, full_nodes, full_ms))
    if arguments.json:
        arguments.json.write_text(json.dumps({"full_step_ms": full_ms, "rows": rows}, indent=2) + "\n")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mesh", default=None, help="tongue; the head of our own when left out")
    parser.add_argument("--recording", type=Path, default=None, help="the demonstration when left out")
    parser.add_argument("--frames", type=int, default=150)
    parser.add_argument("--domains", type=int, nargs="*", default=[5, 8, 12])
    parser.add_argument("--cubature", type=int, nargs="*", default=[])
    parser.add_argument("--json", type=Path, default=None)
    return parser.parse_args()


def _row(
    model: ReducedModel, trajectory: Trajectory, volume: str, full_nodes: np.ndarray, full_ms: float
) -> dict[str, object]:
    pressure = build_pressure_subspace(model, None, [trajectory]) if volume == "subspace" else None
    run = _simulate(SolverReduced(model, PRECISION, TOLERANCES[PRECISION], pressure=pressure), trajectory)
    distance = 1e3 * np.linalg.norm(_surface(run) - full_nodes, axis=2)
    step_ms = float(np.median(run.history.scalar("step_ms")))
    row = {
        "domains": model.domain_count,
        "dof_count": model.dof_count,
        "cubature_elements": len(model.cubature_elements),
        "cubature_error": model.cubature_error,
        "volume": volume,
        "step_ms": step_ms,
        "full_over_reduced": full_ms / step_ms,
        "distance_mm_mean": float(distance.mean()),
        "distance_mm_max": float(distance.max()),
        "unconverged": len(run.unconverged_frames),
    }
    print(
        f"{row['domains']:7d} {row['dof_count']:5d} {row['cubature_elements']:9d} {model.cubature_error:12.3f} "
        f" {volume:8s} {step_ms:8.2f} {full_ms / step_ms:13.1f} {distance.mean():8.3f} {distance.max():7.2f}",
        flush=True,
    )
    return row


def _simulate(solver, trajectory: Trajectory) -> Simulation:
    simulation = Simulation(solver, trajectory)
    simulation.run()
    return simulation


def _surface(simulation: Simulation) -> np.ndarray:
    """Positions of the surface nodes, (frame_count, surface node count, 3) [m]."""
    surface = simulation.solver.tongue.mesh.boundary_nodes
    return np.array([simulation.history.sample(t).nodes[surface] for t in simulation.history.time])


if __name__ == "__main__":
    main()
