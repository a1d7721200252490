"""Cost and coverage of contact: distance grids, collision points, forces, the whole surface.

    python benchmarks/contact.py [--mesh NAME] [--device cpu] [--tongues 1 64 1024]

Training poses are sampled as for a reduced model without recordings. Times are medians after a warm-up; the
grids and the reduced model come from the cache when they are there.
"""

import argparse
import time
from collections.abc import Callable

import numpy as np
import warp as wp

from lingual.model import ReducedModel, RigidPose
from lingual.model.contact_depth import SurfacePenetration
from lingual.model.contact_forces import ContactForces
from lingual.precompute.collision_points import nodes_of, select_collision_points
from lingual.precompute.meshes.library import load_tongue
from lingual.precompute.poses import equilibrium_poses, sampled_displacements
from lingual.precompute.reduction import build_reduced_model
from lingual.precompute.signed_distance import signed_distance_grids

POSES, REPEATS, STEP = 120, 100, 0.01


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mesh", default="head")
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--tongues", type=int, nargs="+", default=[1, 64, 1024])
    arguments = parser.parse_args()
    model = build_reduced_model(load_tongue(arguments.mesh))
    tongue = model.tongue
    started = time.perf_counter()
    grids = signed_distance_grids(tongue)
    print(f"grids: {time.perf_counter() - started:.1f} s")
    for grid in grids:
        print(f"  {grid.frame}: {' x '.join(map(str, grid.values.shape))}, {grid.values.nbytes / 1e6:.1f} MB")
    surface, poses = SurfacePenetration(tongue, grids), _poses(model)
    touching = [surface.measure(*pose) for pose in poses]
    started = time.perf_counter()
    points = select_collision_points(tongue, grids, poses)
    print(
        f"points: {len(points.nodes)} for {1e4 * points.areas.sum():.1f} cm^2 touched in {len(poses)} poses, "
        f"{points.seen_share:.1%} of penetrations seen, {1e3 * points.missed_depth:.2f} mm missed at most, "
        f"{time.perf_counter() - started:.2f} s"
    )
    deepest = poses[int(np.argmax([penetration.deepest for penetration in touching]))]
    print(f"whole surface: {_milliseconds(lambda: surface.measure(*deepest), 'cpu'):.3f} ms")
    displacement = (deepest[0] - tongue.mesh.nodes)[points.nodes]
    for precision in ("float64", "float32"):
        for count in arguments.tongues:
            forces = ContactForces(
                tongue.mesh.nodes[points.nodes],
                points.areas,
                grids,
                tongue_count=count,
                precision_name=precision,
                device=arguments.device,
            )
            forces.displacement.assign(np.repeat(displacement[:, :, None], count, axis=2))
            evaluate, begin = (
                _milliseconds(call, arguments.device) for call in (lambda f=forces: f.evaluate(STEP), forces.begin_step)
            )
            print(f"{precision}, {count} tongues: force {evaluate:.4f} ms, start of a step {begin:.4f} ms")


def _poses(model: ReducedModel) -> list[tuple[np.ndarray, RigidPose]]:
    rng = np.random.default_rng(1)
    displacements = sampled_displacements(model.tongue.sensor_rest_positions, POSES, rng)
    return [(nodes_of(model, q), RigidPose()) for q in equilibrium_poses(model, displacements, rng)]


def _milliseconds(call: Callable[[], object], device: str) -> float:
    times = []
    for _ in range(REPEATS):
        wp.synchronize_device(device)
        started = time.perf_counter()
        call()
        wp.synchronize_device(device)
        times.append(1e3 * (time.perf_counter() - started))
    return float(np.median(times[REPEATS // 10 :]))


if __name__ == "__main__":
    main()
