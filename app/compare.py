"""`lingual compare`: two or three solvers on one trajectory, as table, JSON, plots and pictures."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.table import Table

from ..analysis.solver_comparison import (
    SolverRun,
    SurfaceDistance,
    most_different_time,
    node_distance,
    surface_distance,
)
from ..model import LingualError, TongueModel
from ..precompute.meshes.library import load_tongue
from ..precompute.signed_distance import signed_distance_grids
from .play import check_writable
from .report import simulation_report, write_report
from .simulation import Simulation
from .solver_options import SolverOptions
from .terminal import StageBars, console, stage_bars
from .wiring import build_solver, fitted_trajectory

FEWEST, MOST = 2, 3
PICTURE_COUNT = 4
"""Times that the side-by-side picture shows: three evenly spaced ones and the one of the largest difference."""


@dataclass(frozen=True)
class CompareRequest:
    """What is compared. specifications: solvers as SolverOptions.parse reads them; the reference comes first,
    or is the full-space one when there is one. out: folder for plots and pictures, None for none."""

    recording: Path | None
    specifications: tuple[str, ...]
    mesh: str | None = None
    units: str | None = None
    frame_limit: int | None = None
    out: Path | None = None
    report: Path | None = None


@dataclass(frozen=True, eq=False)
class ComparedRun:
    """A run with what it measured and, unless it is the reference, its distance from that."""

    run: SolverRun
    report: dict[str, object]
    distance: SurfaceDistance | None


def compare(request: CompareRequest) -> None:
    """Runs the solvers, prints the table and writes what is asked for. Raises LingualError for what cannot be used."""
    options = _checked(request)
    for path in (request.out, request.report):
        check_writable(path)
    with stage_bars() as bars:
        tongue = load_tongue(request.mesh, bars, request.units)
        compared = _run_all(request, options, tongue, bars)
    console.print(comparison_table(tongue.name, compared))
    if request.report is not None:
        write_report(request.report, comparison_report(tongue, compared))
    if request.out is not None:  # last: where nothing can be drawn, the figures are there all the same
        with stage_bars() as bars:
            _write_pictures(request.out, tongue, compared, bars)
        console.print(f"Written: {request.out.resolve()}", soft_wrap=True)


def _checked(request: CompareRequest) -> list[SolverOptions]:
    specifications = request.specifications
    if not FEWEST <= len(specifications) <= MOST or len(set(specifications)) < len(specifications):
        raise LingualError(
            f"{len(specifications)} solvers are given ({', '.join(specifications) or 'none'}); name two or three "
            "different ones, such as --solver full --solver reduced --solver reduced:domains=12."
        )
    if request.frame_limit is not None and request.frame_limit < 1:
        raise LingualError(f"--frames is {request.frame_limit}; it must be 1 or more.")
    if request.out is not None and request.out.is_file():
        raise LingualError(f"{request.out} is a file; --out names a folder.")
    return [SolverOptions.parse(text) for text in specifications]


def _run_all(
    request: CompareRequest, options: Sequence[SolverOptions], tongue: TongueModel, bars: StageBars
) -> list[ComparedRun]:
    trajectory = fitted_trajectory(request.recording, tongue)
    if request.frame_limit is not None:
        trajectory = trajectory.head(request.frame_limit)
    grids = signed_distance_grids(tongue, progress=bars)
    solvers = [build_solver(option, tongue, bars)[0] for option in options]  # all, before the first takes its time
    runs, reports = [], []
    for label, solver in zip(request.specifications, solvers, strict=True):
        simulation = Simulation(solver, trajectory, grids)
        _run(simulation, bars.counted(label))
        runs.append(SolverRun(label, solver.dof_count, simulation.history))
        reports.append(simulation_report(simulation, request.mesh or "head"))
    reference = next((k for k, option in enumerate(options) if option.name == "full"), 0)
    compared = []
    for k, (run, report) in enumerate(zip(runs, reports, strict=True)):
        bars("surface distances", k / len(runs))
        distance = None if k == reference else surface_distance(tongue, run, runs[reference])
        compared.append(ComparedRun(run, report, distance))
    bars("surface distances", 1.0)
    return compared


def _run(simulation: Simulation, report_progress: Callable[[int, int], None]) -> None:
    simulation.run(lambda frame: report_progress(frame + 1, simulation.trajectory.frame_count))


def _reference(compared: Sequence[ComparedRun]) -> ComparedRun:
    return next(c for c in compared if c.distance is None)


def comparison_table(name: str, compared: Sequence[ComparedRun]) -> Table:
    """One line for each solver; distances are from the reference's surface."""
    reference = _reference(compared).run
    frames = reference.history.frame_count
    table = Table(title=f"{name}: {frames} frames, distances from the surface of '{reference.label}'")
    table.add_column("solver", overflow="fold")  # a long name gives way, figures never
    for column in ("DOFs", "ms", "mean", "max", "Hausdorff", "volume", "sensor", "det F"):
        table.add_column(column, justify="right", no_wrap=True)
    table.caption = (
        "ms: median of a step. mean, max, Hausdorff: distance in mm, the last after rotation and scale. volume: "
        "greatest change. sensor: greatest error in mm. det F: smallest."
    )
    for each in compared:
        history, distance = each.run.history, each.distance
        apart = ["-"] * 3
        if distance is not None:
            apart = [f"{v:.2f}" for v in (distance.mean.mean(), distance.maximum.max(), distance.hausdorff.max())]
        table.add_row(
            each.run.label,
            f"{each.run.dof_count:,}",
            f"{np.median(history.scalar('step_ms')):.3g}",
            *apart,
            f"{100 * np.abs(history.scalar('volume_ratio') - 1.0).max():.2f} %",
            f"{history.scalar('sensor_error_mm').max():.0e}",
            f"{history.scalar('det_f_min').min():.2f}",
        )
    return table


def comparison_report(tongue: TongueModel, compared: Sequence[ComparedRun]) -> dict[str, object]:
    """The comparison as one JSON object; lengths in mm, energies in J, times in s and ms."""
    reference = _reference(compared).run
    solvers = []
    for each in compared:
        history, distance = each.run.history, each.distance
        per_frame = {
            "step_ms": history.scalar("step_ms").tolist(),
            "volume_ratio": history.scalar("volume_ratio").tolist(),
            "strain_energy": history.scalar("strain_energy").tolist(),
            "sensor_error_mm": history.scalar("sensor_error_mm").tolist(),
        }
        summary: dict[str, object] = {"label": each.run.label, **each.report}
        if distance is not None:
            summary["distance_mm_mean"] = float(distance.mean.mean())
            summary["distance_mm_max"] = float(distance.maximum.max())
            summary["hausdorff_mm_mean"] = float(distance.hausdorff.mean())
            summary["hausdorff_mm_max"] = float(distance.hausdorff.max())
            summary["hausdorff_relative_mean"] = float(distance.relative.mean())
            per_frame["distance_mm_mean"] = distance.mean.tolist()
            per_frame["distance_mm_max"] = distance.maximum.tolist()
            per_frame["hausdorff_mm"] = distance.hausdorff.tolist()
        solvers.append({**summary, "frames": per_frame})
    return {
        "tongue": tongue.name,
        "reference": reference.label,
        "frame_count": reference.history.frame_count,
        "time": reference.history.time.tolist(),
        "solvers": solvers,
    }


def _write_pictures(folder: Path, tongue: TongueModel, compared: Sequence[ComparedRun], bars: StageBars) -> None:
    from ..viewer.picture_table import write_picture_table  # OpenGL is loaded only where it is used
    from .comparison_plots import write_plots

    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise LingualError(f"The folder {folder} cannot be made ({error.strerror}); give another path.") from error
    bars("pictures", 0.0)
    write_plots(folder, compared)
    bars("pictures", 0.3)
    write_picture_table(folder / "shapes.png", _picture_rows(tongue, compared))
    bars("pictures", 1.0)


def _picture_rows(tongue: TongueModel, compared: Sequence[ComparedRun]) -> list:
    """One row of stills a time: the reference, then the others coloured by their distance from it."""
    from ..viewer.session_view import ScalarField
    from ..viewer.stills import PictureRow, Still

    reference = _reference(compared).run
    others = [c for c in compared if c.distance is not None]
    largest = max(others, key=lambda c: c.distance.mean.max())  # type: ignore[union-attr]
    times = reference.history.time
    chosen = {float(times[int(f * (len(times) - 1))]) for f in np.linspace(0, 1, PICTURE_COUNT + 1)[1:-1]}
    chosen.add(most_different_time(largest.run, reference, largest.distance))  # type: ignore[arg-type]
    apart = {(c.run.label, t): node_distance(c.run, reference, t) for c in others for t in chosen}
    limits = (0.0, max(0.1, *(float(np.percentile(d, 99.5)) for d in apart.values())))
    rows = []
    for time in sorted(chosen):
        stills = [Still(reference.label, reference.history.sample(time).nodes)]
        for each in others:
            values = apart[each.run.label, time]
            name = f"{each.run.label}, mean {values[tongue.mesh.boundary_nodes].mean():.2f} mm"
            scalar = ScalarField("distance", values, "mm", limits)
            stills.append(Still(name, each.run.history.sample(time).nodes, scalar))
        rows.append(PictureRow(f"{tongue.name}, {time:.2f} s", tongue, tuple(stills)))
    return rows
