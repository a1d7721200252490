"""Volume correction: none, within the pressure subspace, and in full space, on the same motions in the same run.

    python benchmarks/volume.py [--mesh NAME] [--recordings FILE ...] [--frames N] [--precision float32]
                                [--compliance-mm L] [--modes none subspace full] [--json FILE]

The reduced solver steps through each recording (the demonstration when there is none) and its state is corrected
after every step. Drift is |V - V0| / V0 of the whole tongue; the distribution is that of det F - 1 over all elements
and frames, its standard deviation weighted by volume. The distance is that of the surface from the run with the
full-space correction. Times are medians of one correction of positions and velocities, and their ratio.
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
from lingual.kernels.precision import precision
from lingual.model import Control, ReducedModel, State, Trajectory
from lingual.model.volume import ElementVolumes
from lingual.model.volume_pressure import PressureSubspace
from lingual.precompute.meshes.library import load_tongue
from lingual.precompute.pressure_subspace import build_pressure_subspace
from lingual.precompute.reduction import build_reduced_model
from lingual.solver.reduced import SolverReduced
from lingual.solver.volume_full_space import VolumeFullSpace
from lingual.solver.volume_subspace import SubspaceVolume

Correction = Callable[[State], None]
KEPT_NODES_EVERY = 5
"""Frames between those whose shapes are kept for the distances."""


def main() -> None:
    arguments = _arguments()
    tongue = load_tongue(arguments.mesh)
    recordings = [fitted_trajectory(path, tongue) for path in arguments.recordings or [None]]
    with threadpool_limits(limits=1, user_api="blas"):
        model = build_reduced_model(tongue)
        pressure = build_pressure_subspace(model, None, recordings)
        print(
            f"{tongue.name}: {tongue.mesh.node_count} nodes, {tongue.mesh.tet_count} tets, "
            f"{len(model.cubature_elements)} cubature elements, {pressure.mode_count} pressure modes of "
            f"{pressure.key_frame_count} key frames, error of their Jacobian {pressure.cubature_error:.4f}"
        )
        rows = []
        for recording in recordings:
            corrections = {n: _correction(n, model, pressure, recording, arguments) for n in arguments.modes}
            head = recording.head(arguments.frames)
            runs = {name: _run(model, head, correct) for name, correct in corrections.items()}
            rows += _report(recording.source, tongue.mesh.boundary_nodes, runs)
    if arguments.json:
        arguments.json.write_text(json.dumps(rows, indent=2) + "\n")


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--mesh", default=None, help="tongue; the head of our own when left out")
    parser.add_argument("--recordings", type=Path, nargs="+", default=None)
    parser.add_argument("--frames", type=int, default=10**6)
    parser.add_argument("--precision", default="float64", help="of the subspace correction")
    parser.add_argument("--compliance-mm", type=float, default=None, help="of either; their defaults when left out")
    parser.add_argument("--modes", nargs="+", default=["none", "subspace", "full"])
    parser.add_argument("--json", type=Path, default=None)
    return parser.parse_args()


def _correction(
    name: str, model: ReducedModel, pressure: PressureSubspace, recording: Trajectory, arguments: argparse.Namespace
) -> Correction:
    """Function that corrects a state of the reduced solver in place."""
    length = {} if arguments.compliance_mm is None else {"compliance_length": 1e-3 * arguments.compliance_mm}
    if name == "full":
        return VolumeFullSpace(model.tongue, recording.measured, model.basis, **length).correct
    if name == "none":
        return lambda state: None
    volume = SubspaceVolume(model, pressure, recording.measured, 1, arguments.precision, **length)
    return SubspaceOnState(model, volume, arguments.precision)


class SubspaceOnState:
    """Carries a state's coordinates through the subspace correction; `milliseconds` has the corrections alone."""

    def __init__(self, model: ReducedModel, volume: SubspaceVolume, precision_name: str) -> None:
        self._model = model
        scalar, shape = precision(precision_name).scalar, (model.column_count, 3, 1)
        self._coordinates: wp.array = wp.zeros(shape, dtype=scalar, device="cpu")
        self._velocity: wp.array = wp.zeros(shape, dtype=scalar, device="cpu")
        gradient, self._product = volume.bind_gradient(self._coordinates)
        self._stages = volume.bind_position(self._coordinates, gradient)
        self._stages += volume.bind_velocity(self._velocity, self._coordinates, gradient)
        self.milliseconds: list[float] = []

    def __call__(self, state: State) -> None:
        self._coordinates.numpy()[:, :, 0] = state.coordinates.numpy()
        self._velocity.numpy()[:, :, 0] = state.coordinate_velocity.numpy()
        self._product()
        started = time.perf_counter()
        for stage in self._stages:
            stage()
        self.milliseconds.append(1e3 * (time.perf_counter() - started))
        state.coordinates.numpy()[:] = self._coordinates.numpy()[:, :, 0]
        state.coordinate_velocity.numpy()[:] = self._velocity.numpy()[:, :, 0]
        state.position.numpy()[:] = self._model.tongue.mesh.nodes + self._model.basis @ state.coordinates.numpy()
        state.velocity.numpy()[:] = self._model.basis @ state.coordinate_velocity.numpy()


def _run(model: ReducedModel, recording: Trajectory, correct: Correction) -> dict:
    """Every frame's drift, distribution and sensor error, some shapes, and the median time of a correction."""
    tongue = model.tongue
    solver = SolverReduced(model)
    start, end = solver.new_state(), solver.new_state()
    control = Control(tongue.sensor_rest_positions.copy(), recording.measured)
    elements = ElementVolumes(tongue.mesh, tongue.free_nodes)
    drift, excess, gaps, shapes, times, unconverged = [], [], [], [], [], 0
    for frame, target in enumerate(recording.positions):
        control.sensor_targets[:] = target
        solver.step(start, end, control, 0.01)
        unconverged += not solver.report.converged
        started = time.perf_counter()
        correct(end)
        times.append(1e3 * (time.perf_counter() - started))
        start, end = end, start
        nodes = start.position.numpy()
        elements.set_positions(nodes)
        drift.append(elements.volumes.sum() / tongue.mesh.volume - 1.0)
        excess.append(elements.excess.astype(np.float32))
        gaps.append(np.abs((tongue.sensors.positions(nodes) - target)[recording.measured]).max())
        if frame % KEPT_NODES_EVERY == 0:
            shapes.append(nodes[tongue.mesh.boundary_nodes].copy())
    every = np.array(excess)
    share = tongue.mesh.volumes / tongue.mesh.volume
    return {
        "drift_percent_max": 100.0 * float(np.abs(drift).max()),
        "drift_percent_mean": 100.0 * float(np.abs(drift).mean()),
        "det_f_min": 1.0 + float(every.min()),
        "inverted_frames": int(np.sum(every.min(axis=1) <= -1.0)),
        "excess_std": float(np.sqrt(np.mean(every**2 @ share))),
        "excess_percentile_1": float(np.percentile(every, 1)),
        "excess_percentile_99": float(np.percentile(every, 99)),
        "sensor_error_mm": 1e3 * float(max(gaps)),
        "unconverged": unconverged,
        "correction_ms": float(np.median(getattr(correct, "milliseconds", None) or times)),
        "shapes": np.array(shapes),
    }


def _report(source: str, surface: np.ndarray, runs: dict[str, dict]) -> list[dict]:
    """Prints one table and returns its rows."""
    reference = runs["full"]["shapes"] if "full" in runs else None
    print(f"\n{Path(source).name}")
    print("mode      drift % max/mean  min det F  std     1 %     99 %    sensor mm  ms      distance mm mean/max")
    rows = []
    for name, run in runs.items():
        shapes = run.pop("shapes")
        row = {"recording": Path(source).name, "mode": name, **run}
        if reference is not None:
            distance = 1e3 * np.linalg.norm(shapes - reference, axis=2)
            row |= {"distance_mm_mean": float(distance.mean()), "distance_mm_max": float(distance.max())}
        rows.append(row)
        print(
            f"{name:9} {row['drift_percent_max']:8.5f} {row['drift_percent_mean']:8.5f} {row['det_f_min']:9.3f} "
            f"{row['excess_std']:7.4f} {row['excess_percentile_1']:7.3f} {row['excess_percentile_99']:7.3f} "
            f"{row['sensor_error_mm']:10.1e} {row['correction_ms']:7.3f} "
            f"{row.get('distance_mm_mean', np.nan):7.3f} {row.get('distance_mm_max', np.nan):7.3f}"
            + (f"   {row['unconverged']} steps not converged" if row["unconverged"] else ""),
            flush=True,
        )
    if {"subspace", "full"} <= runs.keys():
        print(f"full / subspace: {runs['full']['correction_ms'] / runs['subspace']['correction_ms']:.0f}")
    return rows


if __name__ == "__main__":
    main()
