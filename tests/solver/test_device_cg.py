"""Conjugate gradients on a device against dense solutions."""

import numpy as np
import pytest
import warp as wp

from lingual.model.discretisation import Discretisation
from lingual.solver import device_cg as module
from lingual.solver.device_cg import DeviceConjugateGradients

RNG = np.random.default_rng(7)


class Clamped:
    """Stiffness and mass of a clamped block as a system on one device, with three random constraint rows."""

    def __init__(self, tongue, device: str) -> None:
        free = tongue.free_nodes
        discretisation = Discretisation(tongue.mesh, tongue.material, free, device=device)
        discretisation.set_displacement(np.zeros_like(tongue.mesh.nodes))
        self.dense = discretisation.stiffness(0.01).toarray()
        self.blocks, self.pattern = discretisation.blocks, discretisation.pattern
        self.J = np.zeros((3, len(self.dense)))
        for row in self.J:
            row[RNG.integers(0, len(self.dense), 4)] = RNG.random(4)
        self.points = tongue.mesh.nodes[free]
        self.device = device

    def solver(self, rows: int) -> DeviceConjugateGradients:
        cg = DeviceConjugateGradients(self.points, self.pattern.row_starts, self.pattern.columns, self.device)
        cg.set_matrix(self.blocks)
        cg.renew(self.J[:rows])
        return cg


@pytest.fixture(scope="module", params=["cpu", pytest.param("cuda:0", marks=pytest.mark.gpu)])
def system(request, small_tongue):
    if request.param != "cpu" and not wp.is_cuda_available():
        pytest.skip("there is no CUDA device")
    return Clamped(small_tongue, request.param)


@pytest.mark.parametrize("rows", [0, 1, 3])
def test_the_solution_is_that_of_the_whole_block_system(system, rows, monkeypatch):
    monkeypatch.setattr(module, "RELATIVE_TOLERANCE", 1e-9)
    J, f, g = system.J[:rows], RNG.standard_normal(len(system.dense)), 1e-3 * RNG.standard_normal(rows)
    x, y = system.solver(rows).solve(f, g)
    whole = np.block([[system.dense, J.T], [J, np.zeros((rows, rows))]])
    expected = np.linalg.solve(whole, np.concatenate([f, g]))
    assert np.linalg.norm(x - expected[: len(x)]) <= 1e-7 * np.linalg.norm(expected[: len(x)])
    np.testing.assert_allclose(y, expected[len(x) :], rtol=1e-6)
    np.testing.assert_allclose(J @ x, g, atol=1e-14)


def test_the_preconditioner_is_symmetric_and_positive(system):
    cg = system.solver(0)
    columns = np.array([cg._preconditioned(row) for row in np.eye(len(system.dense))[::7]])
    sampled = columns[:, ::7]
    np.testing.assert_allclose(sampled, sampled.T, rtol=1e-9, atol=1e-12 * abs(sampled).max())
    assert np.linalg.eigvalsh(sampled).min() > 0.0


def test_the_coarse_space_saves_most_iterations(system, monkeypatch):
    monkeypatch.setattr(module, "CHECKED", 1)
    f = RNG.standard_normal(len(system.dense))
    with_coarse, without = system.solver(0), system.solver(0)
    without._coarse_inverse.zero_()
    with_coarse.solve(f, np.zeros(0))
    without.solve(f, np.zeros(0))
    assert with_coarse.iterations < 0.7 * without.iterations


def test_two_runs_give_the_same_bits(system):
    f = RNG.standard_normal(len(system.dense))
    cg = system.solver(3)
    first, multipliers = cg.solve(f, np.zeros(3))
    again, same = cg.solve(f, np.zeros(3))
    if system.device == "cpu":  # the first run on CUDA takes one iteration more, before its graph is captured
        np.testing.assert_array_equal(first, again)
        np.testing.assert_array_equal(multipliers, same)
    third, _ = cg.solve(f, np.zeros(3))
    np.testing.assert_array_equal(again, third)


def test_an_indefinite_matrix_is_an_error(system):
    cg = system.solver(0)
    blocks = system.blocks.numpy().copy()
    spoilt = wp.array(-blocks, dtype=wp.mat33d, device=system.device)
    cg.set_matrix(spoilt)
    inverse = cg._inverse_diagonal.numpy()
    cg._inverse_diagonal.assign(-inverse)  # a positive preconditioner, a negative matrix
    with pytest.raises(np.linalg.LinAlgError, match="not positive definite"):
        cg.solve(RNG.standard_normal(len(system.dense)), np.zeros(0))


def test_rows_that_repeat_each_other_are_an_error(system):
    system_rows = system.J.copy()
    system_rows[1] = system_rows[0]
    cg = system.solver(0)
    with pytest.raises(np.linalg.LinAlgError):
        cg.renew(system_rows[:2])
    assert not cg.ready
