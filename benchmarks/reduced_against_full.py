"""Reduced solver against full space on one recording: speed as a ratio, distance of the surfaces in mm.

    python benchmarks/reduced_against_full.py --mesh PATH --recording FILE [--frames N] [--domains 5 8 12]

Both solvers converge to the same relative residual on the same machine in the same run. The distance is
between corresponding surface nodes, over all frames.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from lingual.app.simulation import Simulation
from lingual.app.solver_options import SolverOptions
from lingual.app.wiring import build_solver, fitted_trajectory
from lingual.precompute.meshes.library import load_tongue


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mesh", default=None, help="tongue; the head of our own when left out")
    parser.add_argument("--recording", type=Path, default=None, help="the demonstration when left out")
    parser.add_argument("--frames", type=int, default=150)
    parser.add_argument("--domains", type=int, nargs="+", default=[5, 8, 12, 16])
    parser.add_argument("--json", type=Path, default=None)
    arguments = parser.parse_args()

    tongue = load_tongue(arguments.mesh)
    trajectory = fitted_trajectory(arguments.recording, tongue).head(arguments.frames)
    full = _simulate(build_solver(SolverOptions("full"), tongue)[0], trajectory)
    full_nodes, full_ms = _frames(full), float(np.median(full.history.scalar("step_ms")))
    surface = tongue.mesh.boundary_nodes
    print(f"{tongue.name}: {tongue.mesh.node_count} nodes, {tongue.mesh.tet_count} tets, {len(full_nodes)} frames")
    print(f"full space: {full_ms:.1f} ms a step, {len(full.unconverged_frames)} frames not converged")
    print("domains  DOFs  cubature  force error  ms/step  full/reduced  mean mm  max mm")
    rows = []
    for count in arguments.domains:
        solver, model = build_solver(SolverOptions(domains=count), tongue)
        run = _simulate(solver, trajectory)
        distance = 1e3 * np.linalg.norm(_frames(run) - full_nodes, axis=2)[:, surface]
        row = {
            "domains": count,
            "dof_count": model.dof_count,
            "cubature_elements": len(model.cubature_elements),
            "cubature_error": model.cubature_error,
            "step_ms": float(np.median(run.history.scalar("step_ms"))),
            "full_over_reduced": full_ms / float(np.median(run.history.scalar("step_ms"))),
            "distance_mm_mean": float(distance.mean()),
            "distance_mm_max": float(distance.max()),
            "unconverged": len(run.unconverged_frames),
        }
        rows.append(row)
        print(
            f"{count:7d} {row['dof_count']:5d} {row['cubature_elements']:9d} {row['cubature_error']:12.3f} "
            f"{row['step_ms']:8.2f} {row['full_over_reduced']:13.1f} {row['distance_mm_mean']:8.3f} "
            f"{row['distance_mm_max']:7.2f}",
            flush=True,
        )
    if arguments.json:
        arguments.json.write_text(json.dumps({"full_step_ms": full_ms, "rows": rows}, indent=2) + "\n")


def _simulate(solver, trajectory) -> Simulation:
    simulation = Simulation(solver, trajectory)
    simulation.run()
    return simulation


def _frames(simulation: Simulation) -> np.ndarray:
    """All node positions, (frame_count, node_count, 3) [m]."""
    return np.array([simulation.history.sample(t).nodes for t in simulation.history.time])


if __name__ == "__main__":
    main()
