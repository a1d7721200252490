"""Frames a second of modal warping, where the time goes, and how far from reading the modes once that is.

    python benchmarks/modal_warping.py --mesh PATH --recording FILE [--modes 100] [--repeats 3] [--json FILE]

Every figure is a median over the recording's frames. The floor is the time in which one core reads as many bytes
as Phi and Psi of the free nodes take, by a dot product of that length in the same run. On a CUDA device the linear
part and the warp of 1 and of 1,024 tongues are timed in a captured graph.
"""

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import warp as wp
from threadpoolctl import threadpool_limits

from lingual.app.wiring import fitted_trajectory
from lingual.kernels.modal_warping import modal_warping_kernels
from lingual.model import Control, Trajectory
from lingual.model.modal_model import ModalModel
from lingual.precompute.meshes.library import load_tongue
from lingual.precompute.modes import build_modal_model
from lingual.solver.modal_warping import SolverModalWarping

STEP = 0.01


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mesh", default=None, help="tongue; the head of our own when left out")
    parser.add_argument("--recording", type=Path, default=None, help="the demonstration when left out")
    parser.add_argument("--modes", type=int, default=100)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--json", type=Path, default=None)
    arguments = parser.parse_args()

    tongue = load_tongue(arguments.mesh)
    trajectory = fitted_trajectory(arguments.recording, tongue)
    model = build_modal_model(tongue, arguments.modes)
    result: dict[str, object] = {"mesh": tongue.name, "node_count": tongue.mesh.node_count, "modes": arguments.modes}
    print(f"{tongue.name}: {tongue.mesh.node_count} nodes ({len(tongue.free_nodes)} free), {arguments.modes} modes")
    with threadpool_limits(limits=1, user_api="blas"):
        for precision in ("float32", "float64"):
            result[precision] = cpu_figures(model, trajectory, precision, arguments.repeats)
    for device in wp.get_cuda_devices():
        result[device.name] = cuda_figures(model, str(device))
    if arguments.json:
        arguments.json.write_text(json.dumps(result, indent=2) + "\n")


def cpu_figures(model: ModalModel, trajectory: Trajectory, precision: str, repeats: int) -> dict[str, float]:
    """Medians in ms, printed and returned."""
    solver = SolverModalWarping(model, precision)
    stages: dict[str, list[float]] = {}
    for owner, method in (
        (solver._nodes, "_set_coordinates"),
        (solver._nodes, "positions"),
        (solver._newmark, "advance"),
        (solver, "_fill_nodes"),
    ):
        _time_method(owner, method, stages.setdefault(method, []))
    # The stages' clocks would count in the step's, so the step is timed on a solver without them.
    untouched, steps, iterations = SolverModalWarping(model, precision), [], []
    for one in (solver, untouched):
        replay(one, trajectory, repeats, steps, iterations)
    steps, iterations = steps[len(steps) // 2 :], iterations[len(iterations) // 2 :]
    ms = {name: 1e3 * float(np.median(times)) for name, times in stages.items()}
    size = 6 * len(model.tongue.free_nodes) * model.mode_count
    floor = _reading_ms(size, precision)
    step = 1e3 * float(np.median(steps))
    bytes_read = size * np.dtype(precision).itemsize
    figures = {
        "step_ms": step,
        "step_ms_p10": 1e3 * float(np.percentile(steps, 10)),
        "frames_per_second": 1e3 / step,
        "iterations_mean": float(np.mean(iterations)),
        "sensors_and_newmark_ms": ms["advance"],
        "modes_product_ms": ms["_set_coordinates"],
        "warp_ms": ms["positions"] - ms["_set_coordinates"],
        "positions_and_velocities_ms": ms["_fill_nodes"] - ms["positions"],
        "floor_ms": floor,
        "step_over_floor": step / floor,
        "product_gb_per_second": 1e-6 * bytes_read / ms["_set_coordinates"],
    }
    print(f"{precision}: {bytes_read / 1e6:.1f} MB of modes")
    for name, value in figures.items():
        print(f"  {name:<28} {value:10.3f}")
    return figures


def replay(
    solver: SolverModalWarping, trajectory: Trajectory, repeats: int, steps: list[float], iterations: list[int]
) -> None:
    """Appends every step's time [s] and iterations."""
    current, following = solver.new_state(), solver.new_state()
    control = Control(solver.tongue.sensor_rest_positions.copy(), trajectory.measured)
    for targets in np.tile(trajectory.positions, (repeats, 1, 1)):
        control.sensor_targets[:] = targets
        started = time.perf_counter()
        solver.step(current, following, control, STEP)
        steps.append(time.perf_counter() - started)
        iterations.append(solver.report.iterations)
        current, following = following, current


def _time_method(owner: object, method: str, times: list[float]) -> None:
    """Lets every call of a method append its time [s]."""
    original: Callable = getattr(owner, method)

    def timed(*arguments: object) -> object:
        started = time.perf_counter()
        result = original(*arguments)
        times.append(time.perf_counter() - started)
        return result

    setattr(owner, method, timed)


def _reading_ms(size: int, precision: str) -> float:
    """Time [ms] in which one core reads `size` numbers that were read before."""
    numbers = np.ones(size, dtype=precision)
    times = []
    for _ in range(300):
        started = time.perf_counter()
        np.dot(numbers, numbers)
        times.append(time.perf_counter() - started)
    return 1e3 * float(np.median(times))


def cuda_figures(model: ModalModel, device: str) -> dict[str, float]:
    """Time of the linear part and the warp on a CUDA device, float32, by number of tongues."""
    kernels, free = modal_warping_kernels("float32"), model.tongue.free_nodes
    rows = wp.array(model.warping_rows(free).reshape(-1, model.mode_count), dtype=wp.float32, device=device)
    nodes = wp.array(free, dtype=wp.int32, device=device)
    rest = wp.array(model.tongue.mesh.nodes, dtype=wp.vec3f, device=device)
    figures = {}
    for tongues in (1, 1024):
        q = wp.array(1e-3 * np.ones((model.mode_count, 1, tongues)), dtype=wp.float32, device=device)
        linear = wp.zeros((2 * len(free), 3, tongues), dtype=wp.float32, device=device)
        position = wp.zeros((model.tongue.mesh.node_count, 3, tongues), dtype=wp.float32, device=device)

        def frame(linear=linear, q=q, position=position, tongues=tongues) -> None:  # type: ignore[no-untyped-def]
            wp.launch(kernels.linear_part, linear.shape, [rows, q], [linear], device=device)
            wp.launch(kernels.warp, (len(free), tongues), [nodes, rest, linear], [position], device=device)

        frame()
        with wp.ScopedCapture(device) as capture:
            frame()
        wp.synchronize_device(device)
        started = time.perf_counter()
        for _ in range(100):
            wp.capture_launch(capture.graph)
        wp.synchronize_device(device)
        ms = 10.0 * (time.perf_counter() - started)
        figures[f"warp_of_{tongues}_ms"] = ms
        print(f"{device}: linear part and warp of {tongues} tongue{'s' if tongues > 1 else ''} {ms:.4f} ms")
    return figures


if __name__ == "__main__":
    main()
