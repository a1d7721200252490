"""Contact springs: forces are the potential's gradient, they dissipate, and tongues do not see each other."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lingual.model import RigidPose
from lingual.model.contact_forces import ContactForces

RNG = np.random.default_rng(11)
STIFFNESS, DAMPING, STEP = 4e6, 3e-3, 0.01
RIGHT_POSE = RigidPose(Rotation.from_rotvec([0.1, -0.2, 0.15]).as_matrix(), np.array([1e-3, -5e-4, 2e-3]))


@pytest.fixture
def contact(floor, ball):
    """Function (rest, areas=1 mm^2, grids=floor of the jaw and ball of the head, ...) -> ContactForces."""

    def make(rest, areas=None, grids=None, **options) -> ContactForces:
        rest = np.asarray(rest, dtype=float)
        areas = np.full(len(rest), 1e-6) if areas is None else areas
        grids = (floor(-1e-3), ball([0, 0, 6e-3])) if grids is None else grids
        return ContactForces(rest, areas, grids, STIFFNESS, DAMPING, **options)

    return make


def outside(count: int) -> np.ndarray:
    """Points between the default floor and ball, which they do not touch at rest."""
    return np.column_stack([RNG.uniform(-6e-3, 6e-3, (count, 2)), RNG.uniform(-9e-4, 5e-4, count)])


def put(forces: ContactForces, displacement: np.ndarray, start: np.ndarray | None = None, pose=None) -> None:
    """Displacements (n, 3, T); the pose holds at both ends of the step."""
    forces.displacement.assign(displacement)
    forces.displacement_start.assign(np.zeros_like(displacement) if start is None else start)
    for poses in (forces.poses, forces.poses_start):
        poses.assign(pose or RigidPose())
    forces.begin_step()


def as_matrices(stiffness: np.ndarray) -> np.ndarray:
    """(n, 6, T) -> (n, T, 3, 3)."""
    return np.moveaxis(stiffness[:, [[0, 1, 2], [1, 3, 4], [2, 4, 5]]], 3, 1)


@pytest.mark.parametrize("step", [None, STEP])
def test_force_is_the_gradient_of_the_potential(contact, step, device):
    rest = outside(40)
    forces = contact(rest, RNG.uniform(0.5e-6, 2e-6, 40), device=device)
    displacement = RNG.uniform(-4e-3, 4e-3, (40, 3, 1))
    start = displacement + RNG.uniform(-2e-4, 2e-4, (40, 3, 1))

    def energy(at: np.ndarray) -> float:
        put(forces, at, start, RIGHT_POSE)
        forces.evaluate(step)
        return float(forces.energy(step)[0])

    energy(displacement)
    force, depth = forces.force.numpy().copy(), forces.depth.numpy().copy()
    assert (depth[0] > 0).sum() > 2
    assert (depth[1] > 0).sum() > 2
    difference = np.zeros_like(force)
    for place in np.ndindex(force.shape):
        change = np.zeros_like(displacement)
        change[place] = 1e-8
        difference[place] = (energy(displacement + change) - energy(displacement - change)) / 2e-8
    assert force == pytest.approx(difference, abs=1e-5 * np.abs(force).max())


def test_stiffness_is_the_exact_derivative_at_a_plane(contact, floor, device):
    forces = contact(np.zeros((1, 3)), grids=(floor(-1e-4),), device=device)
    x, start = np.array([[[3e-4], [1e-4], [-5e-4]]]), np.array([[[0.0], [0], [-3e-4]]])
    put(forces, x, start)
    forces.evaluate(STEP)
    stiffness = as_matrices(forces.stiffness.numpy())[0, 0]
    assert stiffness == pytest.approx(np.diag([0, 0, STIFFNESS * 1e-6 * (1 + DAMPING / STEP)]), rel=1e-5, abs=1e-9)
    for axis in range(3):
        forward, backward = (np.array(x), np.array(x))
        forward[0, axis] += 1e-7
        backward[0, axis] -= 1e-7
        pushes = []
        for at in (forward, backward):
            put(forces, at, start)
            forces.evaluate(STEP)
            pushes.append(forces.force.numpy()[0, :, 0].copy())
        assert stiffness[:, axis] == pytest.approx((pushes[0] - pushes[1]) / 2e-7, rel=1e-6, abs=1e-8)


def test_stiffness_is_positive_semidefinite_and_its_product_agrees(contact, device):
    forces = contact(outside(10), tongue_count=3, device=device)
    put(forces, RNG.uniform(-4e-3, 4e-3, (10, 3, 3)))
    forces.evaluate(STEP)
    blocks = as_matrices(forces.stiffness.numpy())
    assert np.linalg.eigvalsh(blocks).min() > -1e-9 * np.abs(blocks).max()
    direction, product = forces.displacement_start, forces.force
    values = RNG.standard_normal((10, 3, 3))
    direction.assign(values)
    forces.stiffness_product(direction, product)()
    assert product.numpy() == pytest.approx(np.einsum("ntij,njt->nit", blocks, values), rel=1e-12, abs=1e-9)


def test_points_inside_at_rest_feel_nothing_until_they_go_deeper(contact, floor):
    forces = contact([[0, 0, -2e-4], [1e-3, 0, 5e-4]], grids=(floor(),))
    put(forces, np.zeros((2, 3, 1)))
    forces.evaluate(STEP)
    assert not forces.force.numpy().any()
    put(forces, np.array([[0, 0, -1e-4], [0, 0, -4e-4]])[:, :, None])
    forces.evaluate()
    assert forces.depth.numpy()[0, :, 0] == pytest.approx([1e-4, 0.0], abs=1e-9)
    assert forces.force.numpy()[:, 2, 0] == pytest.approx([-STIFFNESS * 1e-6 * 1e-4, 0.0], rel=1e-4)


def test_damping_resists_entry_and_never_pulls(contact, floor):
    forces = contact(np.zeros((1, 3)), grids=(floor(),))
    k = STIFFNESS * 1e-6
    for depth, start in [(3e-4, 1e-4), (3e-4, 2.9e-4), (1e-4, 3e-4), (1e-6, 3e-4), (2e-4, 0.0)]:
        put(forces, np.array([[[0.0], [0], [-depth]]]), np.array([[[0.0], [0], [-start]]]))
        forces.evaluate(STEP)
        expected = max(0.0, k * depth + k * DAMPING * (depth - start) / STEP)
        assert -forces.force.numpy()[0, 2, 0] == pytest.approx(expected, rel=1e-4, abs=1e-9)


def test_the_head_reaching_the_tongue_is_an_approach(contact, floor):
    """A jaw that closes has a velocity relative to the palate, which the damping sees."""
    still, closing = (contact(np.zeros((1, 3)), grids=(floor(-1e-4, "head"),)) for _ in range(2))
    down = RigidPose(translation=np.array([0, 0, -3e-4]))
    for forces, before in ((still, down), (closing, RigidPose())):
        put(forces, np.zeros((1, 3, 1)), pose=down)
        forces.poses_start.assign(before)
        forces.begin_step()
        forces.evaluate(STEP)
    ratio = closing.force.numpy()[0, 2, 0] / still.force.numpy()[0, 2, 0]
    assert ratio == pytest.approx(1 + DAMPING / STEP, rel=1e-4)


def test_a_mass_dropped_on_a_plane_loses_energy_and_settles(contact, floor):
    """Implicit Euler with the springs' potential; the rest depth is m g / (k A)."""
    mass, gravity, height = 2e-5, 9.81, 2e-3
    forces = contact([[0, 0, height]], grids=(floor(),))
    k = STIFFNESS * 1e-6
    z, velocity = height, 0.0
    energies = []
    for _ in range(400):
        start, h, guess = z, 2e-3, z + 2e-3 * velocity
        for _ in range(20):
            put(forces, np.array([[[0.0], [0], [guess - height]]]), np.array([[[0.0], [0], [start - height]]]))
            forces.evaluate(h)
            residual = mass * ((guess - start) / h - velocity) / h + mass * gravity + forces.force.numpy()[0, 2, 0]
            guess -= residual / (mass / h**2 + forces.stiffness.numpy()[0, 5, 0])
        z, velocity = guess, (guess - start) / h
        energies.append(0.5 * mass * velocity**2 + mass * gravity * z + float(forces.energy()[0]))
    assert np.diff(energies).max() < 1e-12 * mass * gravity * height
    assert z == pytest.approx(-mass * gravity / k, rel=1e-4)
    assert abs(velocity) < 1e-9


def test_moving_the_jaw_equals_moving_the_points(contact, ball):
    """Against the head only: what counts is where points are in the head frame."""
    rest, grids = outside(60), (ball([0, 0, 6e-3]),)
    displacement = RNG.uniform(-4e-3, 4e-3, (60, 3, 1))
    posed, moved = contact(rest, grids=grids), contact(rest, grids=grids)
    put(posed, displacement, pose=RIGHT_POSE)
    in_head = RIGHT_POSE.apply(rest + displacement[:, :, 0]) - rest
    put(moved, in_head[:, :, None], RIGHT_POSE.apply(rest)[:, :, None] - rest[:, :, None])
    for forces in (posed, moved):
        forces.evaluate(STEP)
    assert (moved.depth.numpy() > 0).sum() > 3
    assert posed.depth.numpy() == pytest.approx(moved.depth.numpy(), abs=1e-12)
    back = np.einsum("ij,nit->njt", RIGHT_POSE.rotation, moved.force.numpy())
    assert posed.force.numpy() == pytest.approx(back, abs=1e-9)


def test_a_batch_equals_single_tongues(contact, device):
    rest, tongue_count = outside(20), 5
    displacement, start = RNG.uniform(-4e-3, 4e-3, (2, 20, 3, tongue_count))
    turns = Rotation.from_rotvec(RNG.uniform(-0.1, 0.1, (tongue_count, 3))).as_matrix()
    poses = [RigidPose(turn, RNG.uniform(-1e-3, 1e-3, 3)) for turn in turns]
    batch, single = contact(rest, tongue_count=tongue_count, device=device), contact(rest, device=device)
    put(batch, displacement, start)
    batch.poses.assign(poses)
    batch.evaluate(STEP)
    batch.summarise()
    for t, pose in enumerate(poses):
        put(single, displacement[:, :, [t]], start[:, :, [t]])
        single.poses.assign(pose)
        single.evaluate(STEP)
        single.summarise()
        for name in ("force", "stiffness", "depth"):
            assert np.array_equal(getattr(batch, name).numpy()[:, :, t], getattr(single, name).numpy()[:, :, 0])
        assert batch.energy(STEP)[t] == pytest.approx(single.energy(STEP)[0], rel=1e-12)
        assert batch.deepest.numpy()[t] == single.deepest.numpy()[0] == single.depth.numpy().max()
        assert batch.contact_count.numpy()[t] == (single.depth.numpy().max(axis=0) > 0).sum()


def test_single_precision_agrees(contact, device):
    rest, displacement = outside(20), RNG.uniform(-4e-3, 4e-3, (20, 3, 1))
    double, single = contact(rest), contact(rest, precision_name="float32", device=device)
    for forces in (double, single):
        put(forces, displacement, pose=RIGHT_POSE)
        forces.evaluate(STEP)
    expected = double.force.numpy()
    assert np.abs(single.force.numpy() - expected).max() < 1e-4 * np.abs(expected).max()


def test_no_points_exert_no_force(contact):
    """A tongue that never touches anything in training has none."""
    forces = contact(np.zeros((0, 3)), tongue_count=2)
    forces.begin_step()
    forces.evaluate(STEP)
    forces.summarise()
    forces.stiffness_product(forces.displacement, forces.force)()
    assert forces.energy().tolist() == forces.deepest.numpy().tolist() == [0.0, 0.0]
    assert forces.contact_count.numpy().tolist() == [0, 0]


@pytest.mark.gpu
def test_a_step_is_captured_as_a_graph(contact):
    wp = pytest.importorskip("warp")
    if not wp.is_cuda_available():
        pytest.skip("there is no CUDA device")
    rest, tongue_count = outside(20), 64
    forces = contact(rest, tongue_count=tongue_count, device="cuda:0")
    displacement = RNG.uniform(-4e-3, 4e-3, (2, 20, 3, tongue_count))
    put(forces, displacement[0])
    forces.evaluate(STEP)
    with wp.ScopedCapture("cuda:0") as capture:
        forces.begin_step()
        forces.evaluate(STEP)
        forces.summarise()
    put(forces, displacement[1])
    forces.poses.assign(RIGHT_POSE)
    wp.capture_launch(capture.graph)
    replayed = forces.force.numpy()  # a copy: the array is on the device
    forces.evaluate(STEP)
    assert np.array_equal(replayed, forces.force.numpy())
    assert replayed.any()
