"""Both solvers behind one fixture, and the few lines that drive them."""

import numpy as np
import pytest
import scipy.linalg

from lingual.model import Control, Material
from lingual.model.discretisation import Discretisation
from lingual.precompute.reduction import all_element_model
from lingual.solver.full_space import SolverFullSpace
from lingual.solver.reduced import SolverReduced

STATIC_STEP = 1e4
"""A step [s] so long that inertia and damping vanish beside the elastic forces: one step is statics."""


@pytest.fixture(scope="session", params=["full", "reduced"])
def make_solver(request):
    """Function tongue -> solver; the reduced one integrates every element, so both minimise the same energy."""
    if request.param == "full":
        return SolverFullSpace
    return lambda tongue: SolverReduced(all_element_model(tongue, 5))


@pytest.fixture(scope="session")
def solver(make_solver, small_tongue):
    """Of the small tongue."""
    return make_solver(small_tongue)


@pytest.fixture(scope="session")
def bar(block, tongue_of):
    """A slender bar without damping, 60 x 12 x 12 mm, nu = 0.3, 189 nodes; its sensors are never imposed."""
    return tongue_of(block((0.06, 0.012, 0.012), (20, 2, 2)), BAR_SENSORS, BAR_MATERIAL)


BAR_SENSORS = {"TT": 185, "TB": 131, "TD": 95, "TR": 50}
BAR_MATERIAL = Material(poisson_ratio=0.3, damping_mass=0.0, damping_stiffness=0.0)


@pytest.fixture(scope="session")
def control_of():
    """Function (tongue, displacement [m] by (sensor, axis), gravity) -> Control that imposes just those."""

    def make(tongue, displacement=None, gravity=(0.0, 0.0, 0.0)) -> Control:
        targets = tongue.sensor_rest_positions.copy()
        constrained = np.zeros(targets.shape, dtype=bool)
        for (name, axis), value in (displacement or {}).items():
            place = tongue.sensors.names.index(name), axis
            targets[place] += value
            constrained[place] = True
        return Control(targets, constrained, np.array(gravity, dtype=float))

    return make


@pytest.fixture(scope="session")
def advance():
    """Function (solver, control, dt, steps, state, on_step) -> state after `steps` converged steps from `state`."""

    def run(solver, control, dt, steps=1, state=None, on_step=None):
        current, spare = solver.new_state(), solver.new_state()
        if state is not None:
            current.copy_from(state)
        for _ in range(steps):
            solver.step(current, spare, control, dt)
            assert solver.report.converged
            current, spare = spare, current
            if on_step is not None:
                on_step(current)
        return current

    return run


@pytest.fixture(scope="session")
def static(advance):
    """Function (solver, control, load_steps) -> equilibrium, the load applied in equal parts."""

    def run(solver, control, load_steps=1):
        rest = solver.tongue.sensor_rest_positions
        state = None
        for n in range(1, load_steps + 1):
            share = n / load_steps
            part = Control(
                rest + share * (control.sensor_targets - rest), control.sensor_constrained, share * control.gravity
            )
            state = advance(solver, part, STATIC_STEP, state=state)
        return state

    return run


@pytest.fixture(scope="session")
def displacement():
    """Function (solver, state) -> nodal displacement [m]."""
    return lambda solver, state: state.position.numpy() - solver.tongue.mesh.nodes


@pytest.fixture(scope="session")
def total_energy():
    """Function (solver) -> function state -> kinetic plus strain energy [J]."""

    def of(solver):
        tongue = solver.tongue
        discretisation = Discretisation(tongue.mesh, tongue.material)

        def energy(state) -> float:
            discretisation.set_displacement(state.position.numpy() - tongue.mesh.nodes)
            strain = discretisation.elements.energy_density()[0] @ tongue.mesh.volumes
            kinetic = 0.5 * tongue.node_masses @ np.sum(state.velocity.numpy() ** 2, axis=1)
            return float(strain + kinetic)

        return energy

    return of


class LowestMode:
    """The lowest solution of K x = w^2 M x in a solver's own unknowns, scaled to move 10 um at most.

    omega: w [rad/s].
    """

    def __init__(self, solver) -> None:
        tongue, self._solver = solver.tongue, solver
        self._free = tongue.free_nodes
        self._reduced = isinstance(solver, SolverReduced)
        discretisation = Discretisation(tongue.mesh, tongue.material, self._free)
        discretisation.set_displacement(np.zeros_like(tongue.mesh.nodes))
        K = discretisation.stiffness().toarray()
        M = np.diag(np.repeat(tongue.node_masses[self._free], 3))
        if self._reduced:
            U = np.kron(solver.model.basis[self._free], np.eye(3))
            K, M = U.T @ K @ U, U.T @ M @ U
        squares, vectors = scipy.linalg.eigh(K, M, subset_by_index=[0, 0])
        self.omega = float(np.sqrt(squares[0]))
        self._mode = vectors[:, 0].reshape(-1, 3)
        nodal = solver.model.basis @ self._mode if self._reduced else self._mode
        self._mode *= 1e-5 / abs(nodal).max()
        self._dual = (M @ self._mode.ravel()).reshape(-1, 3)
        self._dual /= np.sum(self._dual * self._mode)

    def state(self, amplitude: float, rate: float = 0.0):
        """A state displaced by `amplitude` modes that moves at `rate` modes a second."""
        state = self._solver.new_state()
        if self._reduced:
            state.coordinates.numpy()[:] = amplitude * self._mode
            state.coordinate_velocity.numpy()[:] = rate * self._mode
        else:
            state.position.numpy()[self._free] += amplitude * self._mode
            state.velocity.numpy()[self._free] = rate * self._mode
        return state

    def amplitude(self, state) -> float:
        """How many modes there are in a state's displacement."""
        if self._reduced:
            return float(np.sum(self._dual * state.coordinates.numpy()))
        moved = state.position.numpy() - self._solver.tongue.mesh.nodes
        return float(np.sum(self._dual * moved[self._free]))


@pytest.fixture(scope="session")
def lowest_mode():
    """Function solver -> LowestMode."""
    return LowestMode
