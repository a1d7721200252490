"""What the size of a seed and the diffusion of the domain weights do to the smallest det F.

    python benchmarks/weight_diffusion.py --mesh PATH --recording FILE [--frames N]

Each row replays the recording on the reduced solver; det F is taken over all elements of the mesh.
"""

import argparse
from pathlib import Path

from lingual.app.simulation import Simulation
from lingual.app.wiring import fitted_trajectory
from lingual.precompute.meshes.library import load_tongue
from lingual.precompute.reduction import ReductionSettings, build_reduced_model
from lingual.solver.reduced import SolverReduced

# Footprint radius and diffusion length [mm].
CASES = [(1.5, 0.0), (2.0, 0.0), (3.0, 0.0), (4.0, 0.0), (5.0, 0.0), (2.0, 2.0), (2.0, 3.0), (2.0, 4.0)]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mesh", default=None, help="tongue; the head of our own when left out")
    parser.add_argument("--recording", type=Path, default=None, help="the demonstration when left out")
    parser.add_argument("--frames", type=int, default=10**6)
    arguments = parser.parse_args()

    tongue = load_tongue(arguments.mesh)
    trajectory = fitted_trajectory(arguments.recording, tongue).head(arguments.frames)
    print(f"{tongue.name}, {trajectory.frame_count} frames")
    print("footprint mm  diffusion mm  min det F  inverted at most  cubature  force error")
    for footprint, diffusion in CASES:
        settings = ReductionSettings(footprint_radius=1e-3 * footprint, diffusion_length=1e-3 * diffusion)
        model = build_reduced_model(tongue, settings)
        simulation = Simulation(SolverReduced(model), trajectory)
        simulation.run()
        history = simulation.history
        print(
            f"{footprint:12.1f} {diffusion:13.1f} {history.scalar('det_f_min').min():10.2f} "
            f"{history.scalar('inverted_tet_count').max():17.0f} {len(model.cubature_elements):9d} "
            f"{model.cubature_error:12.3f}",
            flush=True,
        )


if __name__ == "__main__":
    main()
