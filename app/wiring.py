"""From what the user names to a session: tongue, trajectory, reduced model, solver."""

import warnings
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from pathlib import Path

from ..model import LingualError, ReducedModel, TongueModel, Trajectory
from ..model.contact_scene import ContactScene
from ..model.volume_pressure import PressureSubspace
from ..precompute.contact_scene import build_contact_scene
from ..precompute.meshes.library import load_tongue
from ..precompute.modes import build_modal_model
from ..precompute.pressure_subspace import build_pressure_subspace
from ..precompute.progress import Progress, silent
from ..precompute.reduction import ReductionSettings, build_reduced_model
from ..precompute.signed_distance import signed_distance_grids
from ..solver.full_space import SolverFullSpace
from ..solver.modal_warping import SolverModalWarping
from ..solver.nodal_contact import NodalContact
from ..solver.protocol import Solver
from ..solver.reduced import SolverReduced
from ..solver.volume_corrected import SolverVolumeCorrected
from ..speech.demonstration import demonstration
from ..speech.fitting import fit_to_sensors
from ..speech.loading import load_trajectory
from .session import Session
from .simulation import Simulation
from .solver_options import TOLERANCES, SolverOptions

STEP_RATE = 100.0
"""Simulated frames a second [Hz]: the time step of 0.01 s that DESIGN and Luo (2017, section 8) use."""

COROTATIONAL_NU = 0.45
"""Greatest Poisson's ratio at which a volume correction and the corotational law's tr(S - I) term get along."""


@dataclass(frozen=True)
class SessionRequest:
    """What the user asks for.

    recording: a file, or None for the built-in demonstration. mesh: name or path, None for the head of
    our own. solver: which one, with its options. units: of a mesh file that does not say.
    frame_limit: simulate so many frames only.
    """

    recording: Path | None = None
    mesh: str | None = None
    solver: SolverOptions = field(default_factory=SolverOptions)
    units: str | None = None
    frame_limit: int | None = None


def build_session(request: SessionRequest, progress: Progress = silent) -> Session:
    """A session ready to be started. Raises LingualError for anything that cannot be used."""
    if request.frame_limit is not None and request.frame_limit < 1:
        raise LingualError(f"--frames is {request.frame_limit}; it must be 1 or more.")
    tongue = load_tongue(request.mesh, progress, request.units)
    trajectory = fitted_trajectory(request.recording, tongue)
    if request.frame_limit is not None:
        trajectory = trajectory.head(request.frame_limit)
    solver, reduced = build_solver(request.solver, tongue, progress)
    title = request.recording.name if request.recording else "demonstration"
    grids = signed_distance_grids(tongue, progress=progress)
    return Session(Simulation(solver, trajectory, grids), title, reduced)


def fitted_trajectory(recording: Path | None, tongue: TongueModel) -> Trajectory:
    """Sensor targets at the simulation's rate, from a file or from the demonstration."""
    if recording is None:
        return demonstration(tongue)
    return fit_to_sensors(load_trajectory(recording, rate=STEP_RATE), tongue)


def build_solver(
    options: SolverOptions, tongue: TongueModel, progress: Progress = silent
) -> tuple[Solver, ReducedModel | None]:
    """The chosen solver, and the reduced model that it runs on if it does."""
    tongue = _of_options(tongue, options)
    builders: dict[str, Callable[[], tuple[Solver, ReducedModel | None]]] = {
        "reduced": lambda: _reduced(tongue, options, progress),
        "full": lambda: (_full(tongue, options, progress), None),
        "modal-warping": lambda: (_modal_warping(tongue, options, progress), None),
    }
    solver, model = builders[options.name]()
    return (SolverVolumeCorrected(solver) if options.volume == "full" else solver), model


def reduced_model(tongue: TongueModel, options: SolverOptions, progress: Progress = silent) -> ReducedModel:
    """The tongue's reduced model, its cubature trained on recordings where there are any."""
    tongue = _of_options(tongue, options)
    recordings = [fitted_trajectory(path, tongue) for path in options.train_on]
    return build_reduced_model(tongue, ReductionSettings(domain_count=options.domains), recordings, progress)


def _of_options(tongue: TongueModel, options: SolverOptions) -> TongueModel:
    """The tongue with the chosen material."""
    material = replace(tongue.material, model=options.material)
    if options.material == "corotational" and options.volume != "none" and material.poisson_ratio > COROTATIONAL_NU:
        warnings.warn(
            f"With volume correction the corotational law is simulated at a Poisson's ratio of {COROTATIONAL_NU}, not "
            f"{material.poisson_ratio}: its own volume term works against the correction; volume=none keeps the ratio.",
            stacklevel=2,
        )
        material = replace(material, poisson_ratio=COROTATIONAL_NU)
    return replace(tongue, material=material)


def pressure_subspace(
    model: ReducedModel, options: SolverOptions, progress: Progress = silent
) -> PressureSubspace:
    """The subspace in which a reduced model's volume is corrected."""
    return build_pressure_subspace(model, None, _training_motions(model.tongue, options), progress)


def contact_scene(model: ReducedModel, options: SolverOptions, progress: Progress = silent) -> ContactScene | None:
    """What a reduced tongue may touch; None when nothing is in its reach."""
    return build_contact_scene(model, _training_motions(model.tongue, options), progress)


def _training_motions(tongue: TongueModel, options: SolverOptions) -> list[Trajectory]:
    """The recordings to train on, or the demonstration."""
    return [fitted_trajectory(path, tongue) for path in options.train_on or (None,)]


def _reduced(
    tongue: TongueModel, options: SolverOptions, progress: Progress
) -> tuple[Solver, ReducedModel]:
    model = reduced_model(tongue, options, progress)
    contact = contact_scene(model, options, progress) if options.contact else None
    pressure = pressure_subspace(model, options, progress) if options.volume == "subspace" else None
    solver = SolverReduced(model, options.precision, TOLERANCES[options.precision], contact, pressure)
    return solver, model


def _full(tongue: TongueModel, options: SolverOptions, progress: Progress) -> Solver:
    grids = signed_distance_grids(tongue, progress=progress) if options.contact else ()
    return SolverFullSpace(tongue, terms=(NodalContact(tongue, grids),) if grids else ())


def _modal_warping(tongue: TongueModel, options: SolverOptions, progress: Progress) -> Solver:
    """Nodes in single precision: reading the modes is what a step costs."""
    return SolverModalWarping(build_modal_model(tongue, options.modes, progress), "float32")
