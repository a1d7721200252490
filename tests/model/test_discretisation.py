"""Nodal forces and stiffness of the whole mesh, and their projection on a subspace."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lingual.model import Material
from lingual.model.discretisation import Discretisation
from lingual.model.reduced_forces import ReducedForces
from lingual.model.reduced_model import gradient_operator

STEP = 0.01


@pytest.fixture(scope="module")
def mesh(block):
    return block((0.03, 0.02, 0.02), (2, 2, 2))


@pytest.fixture
def discretisation(mesh):
    return Discretisation(mesh, Material())


@pytest.fixture(scope="module")
def displacement(mesh):
    """A random displacement of up to a few mm, elements stay upright."""
    return 1e-3 * np.random.default_rng(5).standard_normal(mesh.nodes.shape)


def energy(discretisation, displacement):
    discretisation.set_displacement(displacement)
    return float(discretisation.elements.energy_density()[0] @ discretisation.mesh.volumes)


def force(discretisation, displacement, step=None):
    discretisation.set_displacement(displacement)
    return discretisation.internal_force(step).copy()


def test_displacement_gradient_of_a_linear_field_is_its_slope(discretisation, mesh):
    slope = np.array([[0.1, 0.2, 0.0], [0.0, -0.1, 0.3], [0.05, 0.0, 0.02]])
    discretisation.set_displacement(mesh.nodes @ slope.T)
    np.testing.assert_allclose(
        discretisation.elements.gradient.numpy(), np.tile(slope.T, (mesh.tet_count, 1, 1)), atol=1e-12
    )


def test_internal_force_is_the_gradient_of_the_energy(discretisation, displacement):
    numeric = np.zeros_like(displacement)
    for n, i in np.ndindex(*displacement.shape):
        change = np.zeros_like(displacement)
        change[n, i] = 1e-7
        after, before = energy(discretisation, displacement + change), energy(discretisation, displacement - change)
        numeric[n, i] = (after - before) / 2e-7
    exact = force(discretisation, displacement)
    np.testing.assert_allclose(exact, numeric, rtol=0, atol=1e-6 * abs(exact).max())


@pytest.mark.parametrize("step", [None, STEP], ids=["elastic", "damped"])
def test_stiffness_is_the_jacobian_of_the_force_and_symmetric(discretisation, displacement, step):
    discretisation.set_displacement(0.5 * displacement)
    discretisation.elements.begin_step()
    discretisation.set_displacement(displacement)
    K = discretisation.stiffness(step).toarray()
    numeric = np.empty_like(K)
    for column in range(len(K)):
        change = np.zeros(displacement.size)
        change[column] = 1e-7
        change = change.reshape(displacement.shape)
        after = force(discretisation, displacement + change, step)
        numeric[:, column] = (after - force(discretisation, displacement - change, step)).ravel() / 2e-7
    np.testing.assert_allclose(K, numeric, rtol=0, atol=1e-6 * abs(K).max())
    np.testing.assert_allclose(K, K.T, rtol=0, atol=1e-13 * abs(K).max())


def test_rigid_motion_costs_nothing(discretisation, mesh):
    turn = Rotation.from_rotvec([0.5, -1.0, 2.0]).as_matrix()
    moved = mesh.nodes @ turn.T + [0.1, -0.2, 0.3] - mesh.nodes
    scale = Material().lame_lambda * mesh.volume ** (2 / 3)
    assert energy(discretisation, moved) == pytest.approx(0.0, abs=1e-20)
    np.testing.assert_allclose(force(discretisation, moved), 0.0, atol=1e-12 * scale)


def test_infinitesimal_rigid_motions_span_the_null_space_at_rest(discretisation, mesh):
    discretisation.set_displacement(np.zeros_like(mesh.nodes))
    K = discretisation.stiffness().toarray()
    turns = [np.cross(axis, mesh.nodes).ravel() / 0.02 for axis in np.eye(3)]
    rigid = np.column_stack([np.tile(np.eye(3), (mesh.node_count, 1)), *turns])
    np.testing.assert_allclose(K @ rigid, 0.0, atol=1e-12 * abs(K).max())
    eigenvalues = np.linalg.eigvalsh(K)
    assert np.sum(eigenvalues < 1e-9 * eigenvalues[-1]) == 6
    assert eigenvalues[0] > -1e-12 * eigenvalues[-1]


def test_internal_forces_and_their_moments_balance(discretisation, mesh, displacement):
    f = force(discretisation, displacement)
    np.testing.assert_allclose(f.sum(axis=0), 0.0, atol=1e-12 * abs(f).max())
    moment = np.cross(mesh.nodes + displacement, f).sum(axis=0)
    np.testing.assert_allclose(moment, 0.0, atol=1e-12 * abs(f).max() * 0.03)


def test_stiffness_of_free_nodes_is_the_matching_part_of_the_whole(discretisation, mesh, displacement):
    free = np.arange(3, mesh.node_count - 2)
    part = Discretisation(mesh, Material(), free)
    for d in (part, discretisation):
        d.set_displacement(displacement)
    dofs = (3 * free[:, None] + np.arange(3)).ravel()
    whole = discretisation.stiffness().toarray()
    np.testing.assert_allclose(part.stiffness().toarray(), whole[np.ix_(dofs, dofs)], atol=1e-12 * abs(whole).max())


def test_single_precision_agrees_with_double(discretisation, mesh, displacement):
    single = Discretisation(mesh, Material(), precision_name="float32")
    expected = force(discretisation, displacement)
    actual = force(single, displacement.astype(np.float32))
    assert actual.dtype == np.float32
    np.testing.assert_allclose(actual, expected, rtol=0, atol=2e-5 * abs(expected).max())


@pytest.fixture(scope="module")
def subspace(small_tongue):
    """A random basis of four columns, and reduced coordinates that move nodes by about 2 mm."""
    rng = np.random.default_rng(6)
    basis = rng.standard_normal((small_tongue.mesh.node_count, 4))
    return basis, 1e-3 * rng.standard_normal((4, 3))


@pytest.fixture(scope="module")
def reduced_forces(small_tongue, subspace):
    basis, coordinates = subspace
    mesh = small_tongue.mesh
    operator = gradient_operator(small_tongue, basis, np.arange(mesh.tet_count))
    forces = ReducedForces(Material(), operator, mesh.volumes)
    forces.set_coordinates(0.5 * coordinates)
    forces.elements.begin_step()
    forces.set_coordinates(coordinates)
    return forces


@pytest.mark.parametrize("step", [None, STEP], ids=["elastic", "damped"])
def test_reduced_force_and_stiffness_are_the_projected_full_ones(small_tongue, subspace, reduced_forces, step):
    basis, coordinates = subspace
    full = Discretisation(small_tongue.mesh, Material())
    full.set_displacement(basis @ (0.5 * coordinates))
    full.elements.begin_step()
    full.set_displacement(basis @ coordinates)
    U = np.kron(basis, np.eye(3))
    expected = basis.T @ full.internal_force(step)
    np.testing.assert_allclose(reduced_forces.force(step), expected, rtol=0, atol=1e-12 * abs(expected).max())
    K = U.T @ (full.stiffness(step) @ U)
    np.testing.assert_allclose(reduced_forces.stiffness(step), K, rtol=0, atol=1e-12 * abs(K).max())


def test_the_matrix_free_product_equals_the_assembled_stiffness(reduced_forces):
    direction = np.random.default_rng(7).standard_normal((4, 3))
    K = reduced_forces.stiffness(STEP).copy()
    product = reduced_forces.apply_stiffness(direction)
    np.testing.assert_allclose(product.ravel(), K @ direction.ravel(), rtol=0, atol=1e-11 * abs(product).max())
