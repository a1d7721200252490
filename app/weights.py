"""The study of domain weights: table, JSON and side-by-side picture (Luo 2017, Fig. 7 left)."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from ..analysis.weight_study import (
    TREATMENTS,
    WeightStudy,
    WeightTrial,
    study_cantilever,
    study_weights,
    tongue_bend,
)
from ..model import LingualError
from ..model.units import MM_PER_M
from ..precompute.domain_weights import WEIGHTINGS
from ..precompute.meshes.library import load_tongue
from ..precompute.progress import Progress, silent
from ..viewer.session_view import ScalarField
from ..viewer.stills import PictureRow, Still
from .play import check_writable
from .report import write_report
from .terminal import console, stage_bars


def study(meshes: list[str], domain_count: int, shown: str, picture: Path | None, report: Path | None) -> None:
    """Runs the studies, prints their tables and writes what is asked for.

    shown: treatment of the weights in the picture. Raises LingualError for what cannot be used or written.
    """
    check_treatment(shown)
    check_writable(picture)
    check_writable(report)
    with stage_bars() as bars:
        studies = run_studies(meshes, domain_count, bars)
    for found in studies:
        console.print(study_table(found))
    if report is not None:
        write_report(report, {"studies": [study_report(found) for found in studies]})
    if picture is not None:
        from ..viewer.picture_table import write_picture_table  # OpenGL is loaded only where it is used

        rows = [row for found in studies for row in picture_rows(found, shown)]
        console.print(f"Written: {write_picture_table(picture, rows).resolve()}", soft_wrap=True)


def run_studies(meshes: list[str], domain_count: int, progress: Progress = silent) -> list[WeightStudy]:
    """The cantilever, then every tongue (name or path) with its tip lifted."""
    bends = [tongue_bend(load_tongue(mesh, progress)) for mesh in meshes]
    studies = [study_cantilever(progress)]
    return studies + [study_weights(bend, domain_count, progress=progress) for bend in bends]


def check_treatment(name: str) -> None:
    """Raises LingualError for a treatment that there is not."""
    if name not in TREATMENTS:
        raise LingualError(f"There is no treatment of weights '{name}'; choose one of {', '.join(TREATMENTS)}.")


def study_table(study: WeightStudy) -> Table:
    """Errors against the full space, one line for each weighting and treatment; fits 80 columns."""
    tip = MM_PER_M * np.linalg.norm(study.bend.tip_displacement(study.full.displacement))
    mesh = study.bend.tongue.mesh
    table = Table(
        title=f"{study.bend.name}: {len(study.seeds)} domains, {mesh.node_count:,} nodes, {mesh.tet_count:,} "
        f"tetrahedra.\nThe tip moves {tip:.1f} mm in full space; errors of displacement, tip and potential energy"
    )
    table.add_column("weighting", no_wrap=True)
    table.add_column("treatment", no_wrap=True)
    for column in ("displ.", "tip", "energy", "det F", "weights"):
        table.add_column(column, justify="right", no_wrap=True)
    for trial in study.trials:
        table.add_row(
            trial.weighting,
            trial.treatment,
            *(f"{100 * e:.1f} %" for e in (trial.displacement_error, trial.tip_error, trial.energy_error)),
            f"{trial.equilibrium.det_f_min:.2f}" + ("" if trial.equilibrium.converged else " ?"),
            f"{trial.weights.min():.2f} to {trial.weights.max():.2f}",
            end_section=trial.treatment == list(TREATMENTS)[-1],
        )
    if not all(trial.equilibrium.converged for trial in study.trials):
        table.caption = "? not converged"
    return table


def study_report(study: WeightStudy) -> dict[str, object]:
    """The study as one JSON object; lengths in mm, energies in J."""
    bend, mesh = study.bend, study.bend.tongue.mesh
    return {
        "body": bend.name,
        "node_count": mesh.node_count,
        "tet_count": mesh.tet_count,
        "domains": [seed.name for seed in study.seeds],
        "nodes_of_domain": np.bincount(study.partition, minlength=len(study.seeds)).tolist(),
        "load_newton": float(np.linalg.norm(bend.load.sum(axis=0))),
        "full": {
            "tip_mm": (MM_PER_M * bend.tip_displacement(study.full.displacement)).tolist(),
            "potential": study.full.potential,
            "det_f_min": study.full.det_f_min,
            "converged": study.full.converged,
        },
        "trials": [_trial_report(trial) for trial in study.trials],
    }


def _trial_report(trial: WeightTrial) -> dict[str, object]:
    return {
        "weighting": trial.weighting,
        "treatment": trial.treatment,
        "displacement_error": trial.displacement_error,
        "tip_error": trial.tip_error,
        "energy_error": trial.energy_error,
        "det_f_min": trial.equilibrium.det_f_min,
        "converged": trial.equilibrium.converged,
        "weight_range": [float(trial.weights.min()), float(trial.weights.max())],
    }


def picture_rows(study: WeightStudy, treatment: str) -> tuple[PictureRow, PictureRow]:
    """The bends, coloured by their distance from the full space's; and the weights of the domain at the tip."""
    return _bend_row(study, treatment), _weight_row(study, treatment)


def _bend_row(study: WeightStudy, treatment: str) -> PictureRow:
    rest, tongue = study.bend.tongue.mesh.nodes, study.bend.tongue
    trials = [study.trial(weighting, treatment) for weighting in WEIGHTINGS]
    distances = [
        MM_PER_M * np.linalg.norm(trial.equilibrium.displacement - study.full.displacement, axis=1)
        for trial in trials
    ]
    # The scale ends with the second farthest, so that one that is far off does not hide the others' differences.
    limits = (0.0, float(sorted(d.max() for d in distances)[-2]))

    def still(name: str, displacement: NDArray[np.float64], distance: NDArray[np.float64]) -> Still:
        return Still(name, rest + displacement, ScalarField("distance", distance, "mm", limits))

    stills = [still("full space", study.full.displacement, np.zeros(len(rest)))]
    for trial, distance in zip(trials, distances, strict=True):
        name = f"{trial.weighting}, {100 * trial.displacement_error:.1f} %"
        stills.append(still(name, trial.equilibrium.displacement, distance))
    title = f"{tongue.name}: bend with {len(study.seeds)} domains, {treatment} weights, distance from the full space"
    return PictureRow(title, tongue, tuple(stills))


def _weight_row(study: WeightStudy, treatment: str) -> PictureRow:
    tongue = study.bend.tongue
    rest = tongue.mesh.nodes
    tip = int(np.argmax([seed.centre[0] for seed in study.seeds]))
    names = tuple(seed.name for seed in study.seeds)
    partition = ScalarField("domain", study.partition, "", (0.0, len(names) - 1.0), categories=names)
    stills = [Still("domains", rest, partition)]
    for weighting in WEIGHTINGS:
        values = study.trial(weighting, treatment).weights[:, tip]
        stills.append(Still(weighting, rest, ScalarField("weight", values, "", (0.0, 1.0))))
    title = f"{tongue.name}: partition by flooding, and weights of domain {names[tip]}"
    return PictureRow(title, tongue, tuple(stills), view="three-quarter")
