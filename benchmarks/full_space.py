"""Time of one converged full-space step, and what it is spent on.

    python benchmarks/full_space.py [--mesh NAME] [--recording FILE] [--frames N] [--tolerance T ...] [--device D]

Without a recording, the tongue starts at rest in gravity and gravity turns sideways halfway; `--mesh
half-ellipsoid` (default) is a deterministic half-ellipsoid of 10,962 nodes and 56,784 tetrahedra, clamped at its
base. Medians over the frames of one run; wall-clock times of a busy machine say little, so the processor time
of all threads stands beside them. A part that does not occur in every step, such as a factorisation, is given as
its total over the number of steps. A step tolerance of 1e-4, as other codes use, is `--tolerance 1e-4`.
"""

import argparse
import json
import time
from collections import defaultdict
from collections.abc import Callable
from itertools import permutations
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from threadpoolctl import threadpool_limits

from lingual.app.wiring import fitted_trajectory
from lingual.model import Control, EmbeddedSurface, SensorLayout, TetMesh, TongueModel
from lingual.precompute.meshes.library import load_tongue
from lingual.solver.full_space import SolverFullSpace

STEP = 0.01
DIVISIONS, SEMI_AXES = (26, 28, 13), (0.030, 0.025, 0.040)
PARTS = {
    "residual": "residual",
    "precondition": "solutions",
    "renew": "new factors",
    "_tangent": "of them assembly",
    "newton_step": "Newton's linear systems",
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mesh", default="half-ellipsoid")
    parser.add_argument("--recording", type=Path, default=None)
    parser.add_argument("--frames", type=int, default=30)
    parser.add_argument("--tolerance", type=float, nargs="+", default=[1e-8, 1e-4])
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--json", type=Path, default=None)
    arguments = parser.parse_args()
    tongue = half_ellipsoid() if arguments.mesh == "half-ellipsoid" else load_tongue(arguments.mesh)
    targets = None
    if arguments.recording:
        targets = fitted_trajectory(arguments.recording, tongue).head(arguments.frames)
    print(f"{tongue.name}: {tongue.mesh.node_count} nodes, {tongue.mesh.tet_count} tets, {arguments.frames} steps")
    results = []
    for tolerance in arguments.tolerance:
        with threadpool_limits(limits=1, user_api="blas"):
            results.append(measure(tongue, targets, arguments.frames, tolerance, arguments.device))
        _print(results[-1])
    if arguments.json:
        arguments.json.write_text(json.dumps(results, indent=2) + "\n")


def half_ellipsoid() -> TongueModel:
    """The mesh that other codes are measured on: a cube of Kuhn tetrahedra bent into a half-ellipsoid."""
    nodes, tets = _kuhn_grid(DIVISIONS)
    x, y, z = (nodes * [2, 2, 1] - [1, 1, 0]).T
    bend = 0.9  # at 1 the elements on the cube's edges would be flat

    def towards_sphere(a, b):
        return np.sqrt(1.0 - bend * (a * a / 2 + b * b / 2 - a * a * b * b / 3))

    sphere = np.stack([x * towards_sphere(y, z), y * towards_sphere(z, x), z * towards_sphere(x, y)], axis=1)
    mesh = TetMesh(sphere * SEMI_AXES, tets)
    every_node = sp.eye_array(mesh.node_count, format="csr")
    top = int(np.argmax(mesh.nodes[:, 2]))
    skin = EmbeddedSurface(mesh.boundary_triangles, every_node)
    fixed = np.flatnonzero(mesh.nodes[:, 2] == 0.0)
    return TongueModel("half-ellipsoid", mesh, fixed, SensorLayout(("TT",), every_node[[top]]), skin)


def _kuhn_grid(divisions: tuple[int, int, int]) -> tuple[np.ndarray, np.ndarray]:
    shape = tuple(d + 1 for d in divisions)
    nodes = np.stack(np.meshgrid(*(np.linspace(0, 1, n) for n in shape), indexing="ij"), axis=-1).reshape(-1, 3)
    index = np.arange(len(nodes)).reshape(shape)
    a, b, c = divisions
    corners = np.stack([index[i : i + a, j : j + b, k : k + c].ravel() for i, j, k in np.ndindex(2, 2, 2)], axis=1)
    tets = np.concatenate([corners[:, [0, i, i + j, 7]] for i, j, _ in permutations((4, 2, 1))])
    x = nodes[tets]
    turned = np.linalg.det(x[:, 1:] - x[:, :1]) < 0
    tets[turned] = tets[turned][:, [0, 2, 1, 3]]
    return nodes, tets


def measure(tongue: TongueModel, targets, frames: int, tolerance: float, device: str) -> dict:
    """One run; times in ms."""
    spent: dict[str, float] = defaultdict(float)
    started = time.perf_counter()
    solver = SolverFullSpace(tongue, tolerance, device=device)
    set_up = time.perf_counter() - started
    parts = {part: name for part, name in PARTS.items() if hasattr(solver._problem, part)}
    for part in parts:
        _time(solver._problem, part, spent)
    state, spare = solver.new_state(), solver.new_state()
    control = Control(tongue.sensor_rest_positions.copy(), np.zeros((tongue.sensors.count, 3), dtype=bool))
    if targets is not None:
        control.sensor_constrained = targets.measured
    wall, processor, iterations, unconverged = [], [], [], 0
    for frame in range(frames):
        if targets is not None:
            control.sensor_targets[:] = targets.positions[frame]
        else:
            control.gravity[:] = [0.0, 0.0, -9.81] if frame < frames // 2 else [0.0, 9.81, 0.0]
        begun, begun_processor = time.perf_counter(), time.process_time()
        solver.step(state, spare, control, STEP)
        wall.append(1e3 * (time.perf_counter() - begun))
        processor.append(1e3 * (time.process_time() - begun_processor))
        iterations.append(solver.report.iterations)
        unconverged += not solver.report.converged
        state, spare = spare, state
    return {
        "tongue": tongue.name,
        "tolerance": tolerance,
        "set_up_s": set_up,
        "step_ms": float(np.median(wall)),
        "step_ms_mean": float(np.mean(wall)),
        "processor_ms": float(np.median(processor)),
        "processor_ms_mean": float(np.mean(processor)),
        "iterations": float(np.mean(iterations)),
        "unconverged": unconverged,
        "processor_ms_of": {name: spent[part] / frames for part, name in parts.items()},
    }


def _time(problem: object, part: str, spent: dict[str, float]) -> None:
    inner: Callable = getattr(problem, part)

    def timed(*arguments, **named):
        begun = time.process_time()
        try:
            return inner(*arguments, **named)
        finally:
            spent[part] += 1e3 * (time.process_time() - begun)

    setattr(problem, part, timed)


def _print(result: dict) -> None:
    print(
        f"tolerance {result['tolerance']:g}: {result['step_ms']:.0f} ms a step (mean {result['step_ms_mean']:.0f}), "
        f"processor {result['processor_ms']:.0f} ms (mean {result['processor_ms_mean']:.0f}), "
        f"{result['iterations']:.1f} iterations, {result['unconverged']} steps not converged; "
        f"set up once {result['set_up_s']:.1f} s"
    )
    parts = ", ".join(f"{name} {ms:.0f}" for name, ms in result["processor_ms_of"].items())
    print(f"    processor ms a step: {parts}", flush=True)


if __name__ == "__main__":
    main()
