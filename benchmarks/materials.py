"""Constitutive laws on one recording: how far the worst element is compressed, and whether any turns inside out.

    python benchmarks/materials.py --mesh PATH --recording FILE [--solver full] [--frames N] [--material NAME ...]

Simulates the frames around the recording's largest displacement, all of it when --frames is left out, without
volume correction and contact, and prints one row of a table a law.
"""

import argparse
from dataclasses import replace
from pathlib import Path

import numpy as np

from lingual.app.simulation import Simulation
from lingual.app.solver_options import SOLVERS, SolverOptions
from lingual.app.wiring import build_solver, fitted_trajectory
from lingual.kernels.materials import MATERIALS
from lingual.model import TongueModel, Trajectory
from lingual.precompute.meshes.library import load_tongue


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mesh", default=None, help="tongue; the head of our own when left out")
    parser.add_argument("--recording", type=Path, default=None, help="the demonstration when left out")
    parser.add_argument("--solver", choices=SOLVERS, default="reduced")
    parser.add_argument("--frames", type=int, default=None)
    parser.add_argument("--material", nargs="+", choices=MATERIALS, default=list(MATERIALS))
    arguments = parser.parse_args()

    tongue = load_tongue(arguments.mesh)
    trajectory = fitted_trajectory(arguments.recording, tongue)
    if arguments.frames is not None:
        trajectory = around_the_largest_displacement(trajectory, tongue, arguments.frames)
    print(f"{tongue.name}, {arguments.solver}, {trajectory.frame_count} frames from {trajectory.time[0]:.2f} s on")
    print("| material | min det F | inverted | volume within | Newton iterations | halved | not converged | ms |")
    print("|---|---|---|---|---|---|---|---|")
    for material in arguments.material:
        options = SolverOptions(arguments.solver, material=material, volume="none", contact=False)
        simulation = Simulation(build_solver(options, tongue)[0], trajectory)
        simulation.run()
        print(row(material, simulation), flush=True)


def around_the_largest_displacement(trajectory: Trajectory, tongue: TongueModel, count: int) -> Trajectory:
    """`count` frames with the one in their middle in which a sensor is farthest from its rest."""
    distance = np.linalg.norm(np.nan_to_num(trajectory.positions - tongue.sensor_rest_positions), axis=2)
    peak = int(distance.max(axis=1).argmax())
    first = int(np.clip(peak - count // 2, 0, max(trajectory.frame_count - count, 0)))
    kept = slice(first, first + count)
    return replace(
        trajectory,
        time=trajectory.time[kept],
        positions=trajectory.positions[kept],
        jaw_translation=trajectory.jaw_translation[kept],
    )


def row(material: str, simulation: Simulation) -> str:
    """What a simulation went through, as a row of a Markdown table."""
    scalar = simulation.history.scalar
    return (
        f"| {material} | {scalar('det_f_min').min():.3f} | {int(scalar('inverted_tet_count').max())} "
        f"| {100.0 * np.abs(scalar('volume_ratio') - 1.0).max():.2f} % | {scalar('newton_iterations').mean():.1f} "
        f"| {int(np.sum(scalar('substeps') > 1))} | {len(simulation.unconverged_frames)} "
        f"| {np.median(scalar('step_ms')):.0f} |"
    )


if __name__ == "__main__":
    main()
