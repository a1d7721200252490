"""Runs the measures, prints them as tables and writes them as JSON."""

import json
import os
import platform
from collections.abc import Sequence
from pathlib import Path

import warp as wp
from rich.table import Table
from threadpoolctl import threadpool_limits

from ...model import LingualError
from ...precompute.progress import Progress
from ..play import check_writable
from ..report import write_report
from ..terminal import console, stage_bars
from . import measures
from .subject import SIZES, Subject, mesh_of

FRAMES = 200
FULL_FRAMES = 15
REPETITIONS = 200
FULL_VOLUME_REPETITIONS = 5


def bench(sizes: Sequence[str], luo: str | None, peers: Path | None, report: Path | None) -> None:
    """Measures every size, prints a table as each is done and writes the JSON.

    peers: JSON of `benchmarks/peers` (mesh size -> name -> ms), None for none. Raises LingualError for a size
    that there is not or a file that cannot be used.
    """
    for size in sizes:
        if size not in SIZES:
            raise LingualError(f"There is no size '{size}'; choose from {', '.join(SIZES)}.")
    check_writable(report)
    others = _read_peers(peers)
    results: dict[str, object] = {}
    with threadpool_limits(limits=1, user_api="blas"):
        for size in sizes:
            with stage_bars() as bars:
                result = measure(Subject.load(mesh_of(size, luo), bars), size, bars)
            result["peers"] = others.get(size, {})
            results[size] = result
            console.print(result_table(size, result))
            if report is not None:  # what has been measured is kept when a later size is interrupted
                write_report(report, results)
    if report is not None:
        console.print(f"Written: {report.resolve()}", soft_wrap=True)


def _read_peers(path: Path | None) -> dict[str, dict[str, float]]:
    if path is None:
        return {}
    try:
        read = json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise LingualError(f"{path} cannot be read as JSON ({error}); run benchmarks/peers/run.py first.") from error
    if not isinstance(read, dict) or not all(isinstance(figures, dict) for figures in read.values()):
        raise LingualError(f"{path} does not hold figures by mesh size; run benchmarks/peers/run.py to write it.")
    return read


def measure(subject: Subject, label: str, progress: Progress) -> dict[str, object]:
    """All measures of one tongue on the CPU and, where there is one, on the first CUDA device."""
    mesh = subject.tongue.mesh
    stage = f"measuring {label}"
    progress(stage, 0.0)
    reduced = measures.reduced_frame_ms(subject, "cpu", FRAMES)
    progress(stage, 0.2)
    full = measures.full_step_ms(subject, "cpu", FULL_FRAMES)
    progress(stage, 0.5)
    volume_full = measures.volume_full_ms(subject, FULL_VOLUME_REPETITIONS)
    volume_subspace = measures.volume_subspace_ms(subject, "cpu", REPETITIONS)
    progress(stage, 0.7)
    result: dict[str, object] = {
        "mesh": subject.tongue.name,
        "node_count": mesh.node_count,
        "tet_count": mesh.tet_count,
        "dof_count": subject.model.dof_count,
        "cubature_elements": len(subject.model.cubature_elements),
        "contact_points": len(subject.scene.points.nodes) if subject.scene else 0,
        "pressure_modes": subject.pressure.mode_count,
        "tolerance": measures.TOLERANCE,
        "reduced_frame_ms": reduced,
        "reduced_frames_per_second": 1e3 / reduced,
        "full_step_ms": full,
        "full_over_reduced": full / reduced,
        "volume_full_ms": volume_full,
        "volume_subspace_ms": volume_subspace,
        "volume_full_over_subspace": volume_full / volume_subspace,
        "modal_frame_ms": measures.modal_frame_ms(subject, FRAMES),
        "batch_frames_per_second": measures.batch_frames_per_second(subject, "cpu"),
        "batch_size": measures.HOST_BATCH,
        "machine": machine(),
    }
    if wp.is_cuda_available():
        result["cuda"] = _measure_cuda(subject, progress, stage)
    progress(stage, 1.0)
    return result


def _measure_cuda(subject: Subject, progress: Progress, stage: str) -> dict[str, object]:
    device = "cuda:0"
    reduced = measures.reduced_frame_ms(subject, device, FRAMES)
    progress(stage, 0.8)
    full = measures.full_step_ms(subject, device, FULL_FRAMES)
    return {
        "device": wp.get_device(device).name,
        "reduced_frame_ms": reduced,
        "reduced_frames_per_second": 1e3 / reduced,
        "full_step_ms": full,
        "full_over_reduced": full / reduced,
        "volume_subspace_ms": measures.volume_subspace_ms(subject, device, REPETITIONS),
        "batch_frames_per_second": measures.batch_frames_per_second(subject, device),
        "batch_size": measures.DEVICE_BATCH,
    }


def machine() -> str:
    """The machine in words."""
    model = platform.processor() or platform.machine()
    information = Path("/proc/cpuinfo")
    if information.is_file():
        names = [line.split(":", 1)[1].strip() for line in information.read_text().splitlines() if "model name" in line]
        model = names[0] if names else model
    return f"{model}, {os.cpu_count()} cores, {platform.system()}, Python {platform.python_version()}"


def result_table(label: str, result: dict[str, object]) -> Table:
    """The figures of one mesh, CPU beside CUDA where it was measured."""
    cuda = result.get("cuda")
    size = f"{result['node_count']:,} nodes, {result['tet_count']:,} tetrahedra"
    table = Table(title=f"{label}: {result['mesh']}, {size}")
    table.add_column("measure")
    table.add_column("CPU", justify="right", no_wrap=True)
    if isinstance(cuda, dict):
        table.add_column(str(cuda["device"]), justify="right", no_wrap=True)
    rows = {
        "reduced frame with sensors, contact, volume, skin": ("reduced_frame_ms", "ms"),
        "reduced frames a second": ("reduced_frames_per_second", ""),
        f"full-space step, residual {result['tolerance']:g}": ("full_step_ms", "ms"),
        "full over reduced": ("full_over_reduced", "x"),
        "volume correction, full space": ("volume_full_ms", "ms"),
        "volume correction, subspace": ("volume_subspace_ms", "ms"),
        "full over subspace": ("volume_full_over_subspace", "x"),
        "modal warping, 100 modes": ("modal_frame_ms", "ms"),
        "batch, tongue-frames a second": ("batch_frames_per_second", ""),
    }
    for title, (key, unit) in rows.items():
        cells = [_number(result.get(key), unit)]
        if isinstance(cuda, dict):
            cells.append(_number(cuda.get(key), unit))
        table.add_row(title, *cells)
    peers = result.get("peers")
    if isinstance(peers, dict):
        for name, milliseconds in peers.items():
            table.add_row(f"peer: {name}", _number(milliseconds, "ms"))
    table.caption = str(result["machine"])
    return table


def _number(value: object, unit: str) -> str:
    if not isinstance(value, float | int):
        return "-"
    text = f"{value:,.0f}" if value >= 100.0 else f"{value:.3g}"
    return f"{text} {unit}".strip()
