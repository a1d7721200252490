"""From what the user names to a session: tongue, trajectory, reduced model, solver."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from ..model import LingualError, ReducedModel, TongueModel, Trajectory
from ..precompute.meshes.library import load_tongue
from ..precompute.progress import Progress, silent
from ..precompute.reduction import ReductionSettings, build_reduced_model
from ..solver.full_space import SolverFullSpace
from ..solver.protocol import Solver
from ..solver.reduced import SolverReduced
from ..speech.demonstration import demonstration
from ..speech.fitting import fit_to_sensors
from ..speech.loading import load_trajectory
from .session import Session
from .simulation import Simulation

STEP_RATE = 100.0
"""Simulated frames a second [Hz]: the time step of 0.01 s that DESIGN and Luo (2017, section 8) use."""

SOLVERS = ("reduced", "full")


@dataclass(frozen=True)
class SessionRequest:
    """What the user asks for.

    recording: a file, or None for the built-in demonstration. mesh: name or path, None for the head of
    our own. units: of a mesh file that does not say. frame_limit: simulate so many frames only.
    train_on: recordings from which half of the cubature's training poses are taken.
    """

    recording: Path | None = None
    mesh: str | None = None
    solver: str = "reduced"
    domain_count: int = 5
    units: str | None = None
    frame_limit: int | None = None
    train_on: tuple[Path, ...] = ()


def build_session(request: SessionRequest, progress: Progress = silent) -> Session:
    """A session ready to be started. Raises LingualError for anything that cannot be used."""
    if request.solver not in SOLVERS:
        raise LingualError(f"There is no solver '{request.solver}'; choose one of {', '.join(SOLVERS)}.")
    if request.frame_limit is not None and request.frame_limit < 1:
        raise LingualError(f"--frames is {request.frame_limit}; it must be 1 or more.")
    tongue = load_tongue(request.mesh, progress, request.units)
    trajectory = fitted_trajectory(request.recording, tongue)
    if request.frame_limit is not None:
        trajectory = trajectory.head(request.frame_limit)
    solver, reduced = build_solver(request.solver, tongue, request.domain_count, request.train_on, progress)
    title = request.recording.name if request.recording else "demonstration"
    return Session(Simulation(solver, trajectory), title, reduced)


def fitted_trajectory(recording: Path | None, tongue: TongueModel) -> Trajectory:
    """Sensor targets at the simulation's rate, from a file or from the demonstration."""
    if recording is None:
        return demonstration(tongue)
    return fit_to_sensors(load_trajectory(recording, rate=STEP_RATE), tongue)


def build_solver(
    name: str,
    tongue: TongueModel,
    domain_count: int,
    train_on: tuple[Path, ...] = (),
    progress: Progress = silent,
) -> tuple[Solver, ReducedModel | None]:
    """The named solver, and the reduced model that it runs on if it does."""
    builders: dict[str, Callable[[], tuple[Solver, ReducedModel | None]]] = {
        "reduced": lambda: _reduced(tongue, domain_count, train_on, progress),
        "full": lambda: (SolverFullSpace(tongue), None),
    }
    return builders[name]()


def reduced_model(
    tongue: TongueModel, domain_count: int, train_on: tuple[Path, ...] = (), progress: Progress = silent
) -> ReducedModel:
    """The tongue's reduced model, its cubature trained on recordings where there are any."""
    recordings = [fitted_trajectory(path, tongue) for path in train_on]
    return build_reduced_model(tongue, ReductionSettings(domain_count=domain_count), recordings, progress)


def _reduced(
    tongue: TongueModel, domain_count: int, train_on: tuple[Path, ...], progress: Progress
) -> tuple[Solver, ReducedModel]:
    model = reduced_model(tongue, domain_count, train_on, progress)
    return SolverReduced(model), model
