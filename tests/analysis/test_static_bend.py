"""Static bends: closed forms, and what a subspace may and may not do."""

import numpy as np
import pytest

from lingual.analysis.cantilever import SIZE, bar_mesh, load_end_cantilever
from lingual.analysis.static_bend import Bend, bent, scaled_bend
from lingual.model import Material
from lingual.model.discretisation import Discretisation


@pytest.fixture(scope="module")
def cantilever():
    return load_end_cantilever((18, 4, 2))


@pytest.fixture(scope="module")
def full(cantilever):
    return bent(cantilever)


def test_the_grid_fills_the_bar_and_is_a_mirror_image_of_itself():
    mesh = bar_mesh((0.04, 0.02, 0.02), (4, 2, 2))
    assert mesh.tet_count == 5 * 16
    assert mesh.volume == pytest.approx(0.04 * 0.02 * 0.02)
    assert mesh.boundary_triangles.shape == (2 * 2 * (4 * 2 + 4 * 2 + 2 * 2), 3)
    mirrored = mesh.nodes * [1, -1, 1] + [0, 0.02, 0]
    index = [int(np.argmin(np.linalg.norm(mesh.nodes - x, axis=1))) for x in mirrored]
    assert {tuple(sorted(t)) for t in np.array(index)[mesh.tets]} == {tuple(sorted(t)) for t in mesh.tets}


def test_the_equilibrium_balances_the_load(cantilever, full):
    tongue = cantilever.tongue
    discretisation = Discretisation(tongue.mesh, tongue.material)
    discretisation.set_displacement(full.displacement)
    residual = (discretisation.internal_force() - cantilever.load)[tongue.free_nodes]
    assert full.converged
    assert np.linalg.norm(residual) < 1e-7 * np.linalg.norm(cantilever.load)
    assert full.potential < 0.0
    assert not full.displacement[tongue.fixed_nodes].any()


def test_the_load_is_spread_over_the_end_and_bends_without_twist(cantilever, full):
    tongue = cantilever.tongue
    loaded = np.flatnonzero(np.abs(cantilever.load).any(axis=1))
    assert set(loaded) == set(cantilever.tip_nodes)
    assert not cantilever.load[:, :2].any()
    tip = cantilever.tip_displacement(full.displacement)
    assert tip[1] == pytest.approx(0.0, abs=1e-7 * SIZE[0])
    assert 0.3 < -tip[2] / SIZE[0] < 0.6
    assert tip[0] < 0.0
    assert tongue.sensors.names == ("1/3", "2/3", "end")


def test_a_small_load_moves_the_tip_as_asked():
    """Where the response is linear, the scaled load does what it was scaled for."""
    big = load_end_cantilever((12, 2, 2))
    small = scaled_bend("small", big.tongue, big.load, big.tip_nodes, 1e-5)
    moved = small.tip_displacement(bent(small).displacement)
    assert np.linalg.norm(moved) == pytest.approx(1e-5, rel=1e-3)


def test_a_pulled_bar_stretches_by_hookes_law(block, tongue_of):
    """nu = 0, a small load along the axis: force / area = E strain, exactly in linear elements."""
    mesh = block((0.04, 0.01, 0.01), (4, 2, 2))
    bar = tongue_of(mesh, {"TT": mesh.node_count - 1}, Material(poisson_ratio=0.0))
    end = np.flatnonzero(np.isclose(mesh.nodes[:, 0], 0.04))
    triangles = mesh.boundary_triangles[np.isin(mesh.boundary_triangles, end).all(axis=1)]
    share = np.bincount(triangles.ravel(), minlength=mesh.node_count) / triangles.size
    stress = 1e-3
    load = np.outer(share * stress * 1e-4, [1.0, 0.0, 0.0])
    tip = Bend("pulled", bar, load, end).tip_displacement(bent(Bend("pulled", bar, load, end)).displacement)
    assert tip[0] == pytest.approx(0.04 * stress / bar.material.young_modulus, rel=1e-5)


def test_a_subspace_of_everything_gives_the_full_solution_and_a_smaller_one_a_higher_potential():
    bend = load_end_cantilever((6, 2, 2))
    tongue, full = bend.tongue, bent(bend)
    everything = np.eye(tongue.mesh.node_count)
    everything = everything[:, tongue.free_nodes]
    same = bent(bend, everything)
    np.testing.assert_allclose(same.displacement, full.displacement, atol=1e-7 * SIZE[0])
    assert same.potential == pytest.approx(full.potential, rel=1e-9)
    x = tongue.mesh.nodes / SIZE[0]
    potentials = [
        bent(bend, np.column_stack([x[:, 0] ** n * z for n in range(1, degree + 1) for z in (x[:, 2] ** 0, x[:, 2])]))
        for degree in (2, 3, 4)
    ]
    values = [full.potential, *(p.potential for p in reversed(potentials))]
    assert np.all(np.diff(values) > 0.0)
