"""The full-space solver with its whole surface in contact: it stops at the palate and loses energy there."""

import numpy as np
import pytest

from lingual.model import Control, RigidPose
from lingual.model.contact_depth import SurfacePenetration
from lingual.model.signed_distance import SignedDistanceGrid
from lingual.solver.full_space import SolverFullSpace
from lingual.solver.nodal_contact import NodalContact

RNG = np.random.default_rng(13)
CEILING = 0.021
STEP = 0.01


@pytest.fixture(scope="module")
def ceiling() -> tuple[SignedDistanceGrid, ...]:
    """Bone 1 mm above the small block, in the head."""
    lower, spacing = np.array([-0.01, -0.01, 0.01]), 1e-3
    height = lower[2] + spacing * np.arange(26)
    return (SignedDistanceGrid("head", lower, spacing, np.tile((CEILING - height).astype(np.float32), (81, 51, 1))),)


@pytest.fixture
def term(small_tongue, ceiling) -> NodalContact:
    return NodalContact(small_tongue, ceiling)


def free_control(tongue, pose=None) -> Control:
    rest = tongue.sensor_rest_positions
    return Control(rest, np.zeros(rest.shape, dtype=bool), jaw_pose=pose or RigidPose())


def test_term_is_consistent(term, small_tongue):
    nodes = term.nodes
    assert not np.isin(nodes, small_tongue.fixed_nodes).any()
    start = np.zeros((len(nodes), 3))
    x = RNG.uniform(-5e-4, 2.5e-3, (len(nodes), 3))
    term.begin_step(start, free_control(small_tongue), STEP)
    stiffness = term.stiffness(x)
    touching = np.flatnonzero(stiffness[:, 2, 2])
    assert len(touching) > 10
    assert np.allclose(stiffness, stiffness.transpose(0, 2, 1))
    step = np.array([0, 0, 1e-7])
    slope = (term.force(x + step).copy() - term.force(x - step)) / 2e-7
    assert stiffness[touching, :, 2] == pytest.approx(slope[touching], rel=1e-3, abs=1e-6 * slope.max())


def test_a_closing_jaw_does_not_push_the_tongue_through_the_palate(small_tongue, ceiling, term, advance):
    surface = SurfacePenetration(small_tongue, ceiling)
    closed = RigidPose(translation=np.array([0, 0, 2e-3]))
    assert surface.measure(small_tongue.mesh.nodes, closed).deepest == pytest.approx(1.0, abs=1e-3)
    solver = SolverFullSpace(small_tongue, terms=(term,))
    state = advance(solver, free_control(small_tongue, closed), STEP, 30)
    measured = surface.measure(state.position.numpy(), closed)
    assert measured.contact_count > 3
    assert 0.0 < measured.deepest < 0.1


def test_a_tongue_thrown_against_the_palate_gains_no_energy(small_tongue, term, advance, total_energy):
    solver = SolverFullSpace(small_tongue, terms=(term,))
    strain_and_kinetic = total_energy(solver)
    energies, deepest = [], []

    def record(state) -> None:
        displacement = (state.position.numpy() - small_tongue.mesh.nodes)[term.nodes]
        term.force(displacement)  # depths at the end of the step
        deepest.append(float(term.forces.depth.numpy().max()))
        energies.append(strain_and_kinetic(state) + float(term.forces.energy()[0]))

    state = solver.new_state()
    upwards = np.outer(small_tongue.mesh.nodes[:, 0] / 0.06, [0, 0, 3.0])
    state.velocity.numpy()[:] = upwards
    initial = strain_and_kinetic(state)
    advance(solver, free_control(small_tongue), 2e-3, 40, state, record)
    assert max(deepest) > 1e-5
    assert np.diff([initial, *energies]).max() < 1e-9 * initial
