"""What no speaker does must not blow a solver up: speech at twice its speed, a tip pulled 30 mm, a jump of 20 mm.

Every solver on a small block below a hard ceiling; the reduced solver and modal warping also on Luo's mesh. Not blowing
up means: finite everywhere, displaced by a small multiple of what is imposed, back towards rest afterwards, and no
energy out of nothing. Targets inside the ceiling contradict it; sensors are then obeyed, and the surface around is not
let through.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from lingual.app.simulation import Simulation
from lingual.app.solver_options import TOLERANCES, SolverOptions
from lingual.app.wiring import build_solver, fitted_trajectory
from lingual.model import Control, Trajectory
from lingual.model.contact_forces import STIFFNESS, CollisionPoints
from lingual.model.contact_scene import ContactScene
from lingual.model.discretisation import Discretisation
from lingual.model.signed_distance import SignedDistanceGrid
from lingual.precompute.meshes.library import load_tongue
from lingual.precompute.modes import build_modal_model
from lingual.precompute.pressure_subspace import PressureSettings, build_pressure_subspace
from lingual.precompute.reduction import all_element_model
from lingual.solver.full_space import SolverFullSpace
from lingual.solver.modal_warping import SolverModalWarping
from lingual.solver.nodal_contact import NodalContact
from lingual.solver.protocol import Solver
from lingual.solver.reduced import SolverReduced
from lingual.solver.volume_corrected import SolverVolumeCorrected
from lingual.speech.demonstration import demonstration

STEP = 0.01
CEILING = 0.03
"""Height of the bone above the block [m]: 10 mm above its upper side."""
PULL, JUMP = 0.03, 0.02
SOLVERS = (
    "full", "full, volume", "full, contact",
    "reduced float64", "reduced float64, volume", "reduced float64, contact", "reduced float64, both",
    "reduced float32", "reduced float32, both", "reduced float32, full-space volume",
    "modal-warping",
)  # fmt: skip
UP, FORWARD, BACK = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (-0.8, 0.0, 0.6)


@dataclass(frozen=True)
class Block:
    """Solvers of the block. make: function name -> new solver; touched: free surface nodes that contact may see."""

    make: Callable[[str], Solver]
    touched: np.ndarray


@pytest.fixture(scope="module")
def block_solvers(small_tongue, tmp_path_factory) -> Block:
    mesh = small_tongue.mesh
    touched = np.setdiff1d(mesh.boundary_nodes, small_tongue.fixed_nodes)
    lower, spacing = np.array([-0.02, -0.02, 0.0]), 1e-3
    height = lower[2] + spacing * np.arange(80)
    bone = SignedDistanceGrid("head", lower, spacing, np.tile((CEILING - height).astype(np.float32), (131, 71, 1)))
    scene = ContactScene(CollisionPoints(touched, mesh.boundary_areas[touched]), (bone,))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LINGUAL_CACHE", str(tmp_path_factory.mktemp("cache")))
        model, modal = all_element_model(small_tongue, 5), build_modal_model(small_tongue, 100)
        pressure = build_pressure_subspace(model, PressureSettings(key_frame_count=24))

    def make(name: str) -> Solver:
        kind, _, terms = name.partition(", ")
        if kind == "modal-warping":
            return SolverModalWarping(modal, "float32")
        if kind == "full":
            solver = SolverFullSpace(small_tongue, terms=(NodalContact(small_tongue, (bone,)),) * (terms == "contact"))
            return SolverVolumeCorrected(solver) if terms == "volume" else solver
        precision = kind.split()[1]
        solver = SolverReduced(
            model,
            precision,
            TOLERANCES[precision],
            contact=scene if terms in ("contact", "both") else None,
            pressure=pressure if terms in ("volume", "both") else None,
        )
        return SolverVolumeCorrected(solver) if terms == "full-space volume" else solver

    return Block(make, touched)


@pytest.fixture(params=SOLVERS)
def solver(request, block_solvers) -> Solver:
    return block_solvers.make(request.param)


@pytest.fixture
def energy(solver, small_tongue, block_solvers):
    """Function state -> kinetic, strain and spring energy [J] of what the solver integrates."""
    if isinstance(solver, SolverModalWarping):
        return lambda state: solver.strain_energy(state) + 0.5 * float(np.sum(state.coordinate_velocity.numpy() ** 2))
    mesh = small_tongue.mesh
    discretisation = Discretisation(mesh, small_tongue.material)
    areas = mesh.boundary_areas[block_solvers.touched] * (solver.contact_point_count > 0)

    def of(state) -> float:
        nodes, velocity = (a.numpy().astype(float) for a in (state.position, state.velocity))
        discretisation.set_displacement(nodes - mesh.nodes)
        strain = discretisation.elements.energy_density()[0] @ mesh.volumes
        kinetic = 0.5 * small_tongue.node_masses @ np.sum(velocity**2, axis=1)
        depth = np.maximum(nodes[block_solvers.touched, 2] - CEILING, 0.0)
        return float(strain + kinetic + 0.5 * STIFFNESS * areas @ depth**2)

    return of


def twice_as_fast(trajectory: Trajectory) -> Trajectory:
    """The same path in half the time, again at one frame a STEP."""
    time = np.arange(0.0, 0.5 * trajectory.duration + 0.5 * STEP, STEP)

    def resampled(values: np.ndarray) -> np.ndarray:
        flat = values.reshape(trajectory.frame_count, -1)
        columns = [np.interp(2.0 * time, trajectory.time - trajectory.time[0], column) for column in flat.T]
        return np.stack(columns, axis=1).reshape(len(time), *values.shape[1:])

    return replace(
        trajectory,
        time=time,
        positions=resampled(trajectory.positions),
        jaw_translation=resampled(trajectory.jaw_translation),
    )


def jump(tongue, direction, before: int = 2, held: int = 8, after: int = 8) -> Trajectory:
    """The first sensor, by JUMP in one frame, and back in one frame; the others stay where they rest."""
    rest = tongue.sensor_rest_positions
    positions = np.tile(rest, (before + held + after, 1, 1))
    positions[before : before + held, 0] += JUMP * np.array(direction)
    return Trajectory(
        time=STEP * np.arange(len(positions)),
        channels=tongue.sensors.names,
        positions=positions,
        measured=np.tile([True, False, True], (len(rest), 1)),
        frame="jaw",
        source="jump",
    )


@dataclass(frozen=True)
class Outcome:
    """Of a simulation: farthest coordinate of a node's displacement in each frame, and of what is imposed [m]."""

    simulation: Simulation
    displaced: np.ndarray
    imposed: float

    def of(self, name: str) -> np.ndarray:
        return self.simulation.history.scalar(name)


def simulate(solver: Solver, trajectory: Trajectory) -> Outcome:
    """The outcome; every frame of it finite."""
    simulation = Simulation(solver, trajectory)
    simulation.run()
    nodes = np.array([simulation.history.sample(time).nodes for time in trajectory.time])
    assert np.isfinite(nodes).all()
    tongue = solver.tongue
    imposed = (trajectory.positions - tongue.sensor_rest_positions)[:, trajectory.measured]
    return Outcome(simulation, abs(nodes - tongue.mesh.nodes).max(axis=(1, 2)), float(abs(imposed).max()))


def reach(solver: Solver) -> float:
    """How far nodes may go, as a multiple of what is imposed.

    Modal warping lets sensors that are close together lever distant parts about (docs/design/modal_warping.md).
    """
    return 3.0 if solver.name == "modal-warping" else 1.6


def pulled_and_released(solver: Solver, direction, frames: int = 6, after: int = 24):
    """States of the tip's sensor pulled by PULL in even steps, then of nothing imposed: a list of each."""
    rest = solver.tongue.sensor_rest_positions
    mask = np.zeros(rest.shape, dtype=bool)
    mask[0] = [True, False, True]
    pull, free = Control(rest.copy(), mask), Control(rest.copy(), np.zeros_like(mask))
    states = [solver.new_state()]
    for n in range(frames + after):
        pull.sensor_targets[0] = rest[0] + min(1.0, (n + 1) / frames) * PULL * np.array(direction)
        states.append(solver.new_state())
        solver.step(states[-2], states[-1], pull if n < frames else free, STEP)
        for name in ("position", "velocity", "coordinates", "coordinate_velocity", "sensor_force"):
            assert np.isfinite(getattr(states[-1], name).numpy()).all(), (name, n)
    return states[1 : frames + 1], states[frames + 1 :]


def displaced(solver: Solver, state) -> float:
    return float(abs(state.position.numpy() - solver.tongue.mesh.nodes).max())


def test_speech_at_twice_its_speed(solver, small_tongue):
    trajectory = twice_as_fast(demonstration(small_tongue)).head(50)
    outcome = simulate(solver, trajectory)
    speed = abs(np.diff(trajectory.positions, axis=0)).max() / STEP
    assert speed > 0.15  # m/s, of the fastest coil
    assert outcome.simulation.unconverged_frames == []
    assert outcome.displaced.max() < reach(solver) * outcome.imposed
    assert outcome.of("sensor_error_mm").max() < 0.01
    if solver.volume_mode != "none":
        assert abs(outcome.of("volume_ratio") - 1.0).max() < 2e-3


@pytest.mark.parametrize("direction", [UP, BACK], ids=["up", "back"])
def test_a_sensor_jumps_20_mm_in_one_frame_and_back(solver, small_tongue, direction):
    outcome = simulate(solver, jump(small_tongue, direction))
    assert outcome.displaced.max() < reach(solver) * JUMP
    assert outcome.displaced[-1] < 0.9 * outcome.displaced.max()
    assert outcome.of("sensor_error_mm").max() < 0.01
    assert outcome.simulation.unconverged_frames == []


@pytest.mark.parametrize("direction", [UP, FORWARD], ids=["up", "forward"])
def test_a_tip_pulled_30_mm_and_let_go_comes_back_and_gains_no_energy(solver, energy, direction):
    pulled, released = pulled_and_released(solver, direction)
    farthest = max(displaced(solver, state) for state in pulled)
    assert 0.7 * PULL < farthest < reach(solver) * PULL
    energies = np.array([energy(state) for state in [pulled[-1], *released]])
    assert energies.max() <= energies[0] * 1.0001
    assert np.diff(energies).max() <= 1e-6 * energies[0]
    assert energies[-1] < 0.15 * energies[0]
    assert displaced(solver, released[-1]) < 0.6 * farthest


@pytest.fixture(params=["neo-hookean", "corotational", "mooney-rivlin"])
def other_tongue(request, small_tongue):
    """The block of another law."""
    return replace(small_tongue, material=replace(small_tongue.material, model=request.param))


# Trials of a step that is then halved may overflow.
@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("kind", ["full", "reduced"])
@pytest.mark.parametrize("direction", [UP, BACK], ids=["up", "back"])
def test_a_sensor_of_another_law_jumps_20_mm_in_one_frame_and_back(other_tongue, block_solvers, kind, direction):
    if kind == "full":
        solver = SolverFullSpace(other_tongue)
    else:
        solver = SolverReduced(replace(block_solvers.make("reduced float64").model, tongue=other_tongue))
    outcome = simulate(solver, jump(other_tongue, direction))
    assert outcome.simulation.unconverged_frames == []
    assert outcome.displaced.max() < reach(solver) * JUMP
    strain_energy = outcome.of("strain_energy")  # a tongue rolled up unrolls slowly, but it does
    assert strain_energy[-1] < 0.9 * strain_energy.max()
    assert outcome.of("sensor_error_mm").max() < 0.01


@pytest.mark.parametrize("direction", [UP, FORWARD], ids=["up", "forward"])
def test_single_precision_follows_double_precision_through_pull_and_release(block_solvers, direction):
    single, double = (
        [state for part in pulled_and_released(solver, direction, after=15) for state in part]
        for solver in map(block_solvers.make, ("reduced float32, both", "reduced float64, both"))
    )
    gaps = [abs(a.position.numpy() - b.position.numpy()).max() for a, b in zip(single, double, strict=True)]
    assert max(gaps) < 5e-6


@pytest.fixture(scope="module")
def luo_tongue(shared_data):
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("warnings.warn", lambda *_, **__: None)
        return load_tongue(shared_data / "luo_tongue")


@pytest.fixture(scope="module", params=["reduced", "reduced:precision=float64", "modal-warping"])
def luo_solver(request, luo_tongue):
    """As the command line builds it; what is precomputed comes from the user's cache."""
    return build_solver(SolverOptions.parse(request.param), luo_tongue)[0]


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore")
def test_a_measured_sentence_at_twice_its_speed(luo_solver, luo_tongue, shared_data):
    path = shared_data / "ema" / "luo" / "20150624_0_041_sync.txt"
    trajectory = twice_as_fast(fitted_trajectory(path, luo_tongue))
    assert trajectory.frame_count == 376
    outcome = simulate(luo_solver, trajectory)
    assert outcome.simulation.unconverged_frames == []
    assert outcome.displaced.max() < reach(luo_solver) * outcome.imposed
    assert outcome.of("sensor_error_mm").max() < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("direction", [UP, BACK], ids=["up", "back"])
def test_a_sensor_jumps_20_mm_on_the_measured_mesh(luo_solver, luo_tongue, direction):
    outcome = simulate(luo_solver, jump(luo_tongue, direction))
    assert outcome.simulation.unconverged_frames == []  # single precision too, while the tongue relaxes
    assert outcome.displaced.max() < reach(luo_solver) * JUMP
    assert outcome.displaced[-1] < 0.9 * outcome.displaced.max()
    assert outcome.of("sensor_error_mm").max() < 0.01


@pytest.mark.slow
@pytest.mark.parametrize("direction", [UP, FORWARD], ids=["up", "forward"])
def test_the_measured_tip_pulled_30_mm_and_let_go_comes_back(luo_solver, direction):
    pulled, released = pulled_and_released(luo_solver, direction)
    farthest = max(displaced(luo_solver, state) for state in pulled)
    assert 0.7 * PULL < farthest < reach(luo_solver) * PULL
    way = [displaced(luo_solver, state) for state in released]
    assert way[-1] < 0.6 * farthest
