"""Vibration modes: orthogonality, frequencies of a cantilever, Lanczos against a dense eigensolver, the cache."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lingual.model import LingualError, Material
from lingual.model.discretisation import Discretisation
from lingual.model.modal_model import nodal_curl
from lingual.precompute.modes import build_modal_model

pytestmark = pytest.mark.usefixtures("cache_folder")


def stiffness_times(tongue, modes: np.ndarray) -> np.ndarray:
    discretisation = Discretisation(tongue.mesh, tongue.material)
    discretisation.set_displacement(np.zeros_like(tongue.mesh.nodes))
    return discretisation.stiffness() @ modes


@pytest.mark.parametrize("count", [20, 150])  # by Lanczos iteration, by a dense solver
def test_modes_are_orthonormal_in_mass_and_orthogonal_in_stiffness(small_tongue, count):
    model = build_modal_model(small_tongue, count)
    mass = np.repeat(small_tongue.node_masses, 3)[:, None]
    assert model.modes.shape == (3 * small_tongue.mesh.node_count, count)
    np.testing.assert_allclose(model.modes.T @ (mass * model.modes), np.eye(count), atol=1e-10)
    stiffness = model.modes.T @ stiffness_times(small_tongue, model.modes)
    np.testing.assert_allclose(stiffness, np.diag(model.eigenvalues), atol=1e-9 * model.eigenvalues[-1])
    assert np.all(np.diff(model.eigenvalues) >= 0.0)


def test_lanczos_iteration_finds_the_modes_of_the_dense_solver(small_tongue):
    few, many = build_modal_model(small_tongue, 20), build_modal_model(small_tongue, 150)
    np.testing.assert_allclose(few.eigenvalues, many.eigenvalues[:20], rtol=1e-9)
    np.testing.assert_allclose(few.modes, many.modes[:, :20], atol=1e-6 * abs(few.modes).max())


def test_fixed_nodes_do_not_move(small_tongue):
    modes = build_modal_model(small_tongue, 12).modes.reshape(-1, 3, 12)
    assert not modes[small_tongue.fixed_nodes].any()
    assert abs(modes[small_tongue.free_nodes]).max(axis=(1, 2)).min() > 0.0


def test_a_cantilever_rings_as_slender_beams_do(block, tongue_of):
    """Euler and Bernoulli's first two frequencies, less Timoshenko's 1 and 4 % for this bar, as the mesh is refined.

    Linear tetrahedra are too stiff in bending by an error of second order: extrapolated from two meshes.
    """
    length, height = 0.1, 0.01
    material = Material(poisson_ratio=0.0)
    squares = []
    for across in (2, 4):
        tongue = tongue_of(block((length, height, height), (10 * across, across, across)), {"TT": 5}, material)
        squares.append(build_modal_model(tongue, 4).eigenvalues)
    extrapolated = np.sqrt(squares[1] + (squares[1] - squares[0]) / 3.0)
    speed = np.sqrt(material.young_modulus / material.density)
    beam = np.array([1.875104, 1.875104, 4.694091, 4.694091]) ** 2 * speed * height / np.sqrt(12.0) / length**2
    assert np.all(squares[0] > squares[1])
    np.testing.assert_allclose(extrapolated[:2], beam[:2], rtol=0.02)
    np.testing.assert_allclose(extrapolated[2:], 0.96 * beam[2:], rtol=0.03)


def test_damping_and_frequencies_follow_from_the_eigenvalues(small_tongue):
    model = build_modal_model(small_tongue, 5)
    omega, material = 2.0 * np.pi * model.frequencies, small_tongue.material
    ratio = 0.5 * (material.damping_mass / omega + material.damping_stiffness * omega)
    np.testing.assert_allclose(model.damping, 2.0 * ratio * omega)


def test_the_curl_of_a_rotation_is_the_rotation_and_that_of_a_stretch_nothing(small_tongue):
    curl, nodes = nodal_curl(small_tongue.mesh), small_tongue.mesh.nodes
    spin = np.array([0.3, -0.2, 0.5])
    turned = curl @ np.cross(spin, nodes).ravel()
    np.testing.assert_allclose(turned.reshape(-1, 3), np.tile(spin, (len(nodes), 1)), atol=1e-12)
    axes = Rotation.from_rotvec([0.4, 0.1, 0.9]).as_matrix()
    stretched = nodes @ (axes @ np.diag([1.0, -0.5, 2.0]) @ axes.T)
    np.testing.assert_allclose(curl @ stretched.ravel(), 0.0, atol=1e-12)


def test_rotation_modes_are_the_volume_weighted_mean_of_element_curls(small_tongue):
    mesh, model = small_tongue.mesh, build_modal_model(small_tongue, 3)
    u = model.modes[:, 2].reshape(-1, 3)
    gradient = np.einsum("eaj,eai->eji", mesh.shape_gradients, u[mesh.tets])  # [e, j, i] = du_i/dX_j
    curl = np.stack([gradient[:, 1, 2] - gradient[:, 2, 1], gradient[:, 2, 0] - gradient[:, 0, 2],
                     gradient[:, 0, 1] - gradient[:, 1, 0]], axis=1)  # fmt: skip
    for n in (0, 37, 111):
        around = np.any(mesh.tets == n, axis=1)
        expected = 0.5 * np.average(curl[around], axis=0, weights=mesh.volumes[around])
        np.testing.assert_allclose(model.rotation_modes[3 * n : 3 * n + 3, 2], expected, atol=1e-10)


def test_modes_come_from_the_cache_the_second_time(small_tongue):
    def reported(count: int) -> list[float]:
        shares: list[float] = []
        build_modal_model(small_tongue, count, lambda stage, share: shares.append(share))
        return shares

    first = reported(8)
    assert first[0] == 0.0
    assert first[-1] == 1.0
    assert first == sorted(first)
    assert reported(8) == []
    assert reported(9) != []


@pytest.mark.parametrize("count", [0, 481])
def test_a_number_of_modes_that_the_mesh_does_not_have_is_refused(small_tongue, count):
    with pytest.raises(LingualError, match=f"{count} modes were asked for.*1 to 480"):
        build_modal_model(small_tongue, count)


@pytest.mark.parametrize("count", [4, 100])
def test_a_loose_piece_is_refused(block, tongue_of, count):
    held, loose = block((0.02, 0.01, 0.01), (3, 2, 2)), block((0.02, 0.01, 0.01), (3, 2, 2))
    nodes = np.concatenate([held.nodes, loose.nodes + np.array([0.03, 0.0, 0.0])])
    mesh = type(held)(nodes, np.concatenate([held.tets, loose.tets + held.node_count]))
    with pytest.raises(LingualError, match="hangs on no fixed node"):
        build_modal_model(tongue_of(mesh, {"TT": 5}), count)
