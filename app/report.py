"""What a run measured, as one JSON object."""

import json
import platform
from pathlib import Path

import numpy as np

from ..model import LingualError
from .simulation import Simulation


def simulation_report(simulation: Simulation, mesh_name: str) -> dict[str, object]:
    """Figures of the frames simulated so far; times in ms, lengths in mm."""
    solver, history = simulation.solver, simulation.history
    mesh = solver.tongue.mesh
    step_ms = history.scalar("step_ms")
    any_frame = len(step_ms) > 0

    def of(function, name: str) -> float | None:  # type: ignore[no-untyped-def]
        return float(function(history.scalar(name))) if any_frame else None

    return {
        "solver": solver.name,
        "mesh": mesh_name,
        "node_count": mesh.node_count,
        "tet_count": mesh.tet_count,
        "dof_count": solver.dof_count,
        "source": simulation.trajectory.source,
        "frame_count": history.frame_count,
        "step_ms": {
            "median": of(np.median, "step_ms"),
            "p95": of(lambda values: np.percentile(values, 95), "step_ms"),
        },
        "frames_per_second": 1e3 * len(step_ms) / float(step_ms.sum()) if any_frame else None,
        "volume_drift_max": of(lambda ratio: np.abs(ratio - 1.0).max(), "volume_ratio"),
        "det_f_min": of(np.min, "det_f_min"),
        "sensor_error_mm_max": of(np.max, "sensor_error_mm"),
        "material": solver.tongue.material.model,
        "volume_mode": solver.volume_mode,
        "contact_points": solver.contact_point_count,
        "contact_count_max": int(history.scalar("contact_count").max()) if any_frame else None,
        "penetration_mm_max": of(np.max, "penetration_mm"),
        "newton_iterations_mean": of(np.mean, "newton_iterations"),
        "inverted_tet_count_max": int(history.scalar("inverted_tet_count").max()) if any_frame else None,
        "unconverged_frames": simulation.unconverged_frames,
        "halved_frame_count": int(np.sum(history.scalar("substeps") > 1)) if any_frame else 0,
        "machine": f"{platform.system()} {platform.machine()}, Python {platform.python_version()}",
    }


def write_report(path: Path, report: dict[str, object]) -> None:
    """Writes the report as JSON. Raises LingualError when the file cannot be written."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(report, indent=2) + "\n")
    except OSError as error:
        raise LingualError(f"The report {path} cannot be written ({error.strerror}); give another path.") from error
