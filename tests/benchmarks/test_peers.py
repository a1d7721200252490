"""The judge of the peers benchmark: what it measures from positions alone."""

from pathlib import Path

import numpy as np
import pytest

PEERS = Path(__file__).parents[2] / "benchmarks" / "peers"


@pytest.fixture
def accuracy(monkeypatch):
    monkeypatch.syspath_prepend(str(PEERS))
    import accuracy

    return accuracy


@pytest.fixture
def problem(accuracy):
    """Two tetrahedra that share a face, free of supports, in 2 g."""
    nodes = 0.01 * np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1.1, 0.9, 1.2]])
    return accuracy.StepProblem(
        mesh="",
        nodes=nodes,
        tets=np.array([[0, 1, 2, 3], [1, 2, 3, 4]]),
        fixed=np.empty(0, dtype=np.int64),
        young_modulus=5000.0,
        poisson_ratio=0.45,
        density=1000.0,
        gravity=np.array([1.0, -2.0, -19.0]),
        step=0.01,
        step_count=4,
        reduced_step_count=4,
        tolerance=1e-5,
        budget=1.0,
        basis=np.zeros((5, 1)),
        cubature_elements=np.array([0]),
        cubature_weights=np.array([1.0]),
    )


def stvk_energy(problem, positions):
    energy = 0.0
    for tet in problem.tets:
        D = (problem.nodes[tet[1:]] - problem.nodes[tet[0]]).T
        F = (positions[tet[1:]] - positions[tet[0]]).T @ np.linalg.inv(D)
        E = 0.5 * (F.T @ F - np.eye(3))
        density = problem.lame_mu * np.sum(E * E) + 0.5 * problem.lame_lambda * np.trace(E) ** 2
        energy += abs(np.linalg.det(D)) / 6.0 * density
    return energy


def free_fall(problem, steps=4):
    """Implicit Euler from rest without forces but gravity: the velocity after n steps is n h g."""
    n = np.arange(1, steps + 1)
    return problem.nodes + (n * (n + 1) / 2 * problem.step**2)[:, None, None] * problem.gravity


def test_internal_force_is_the_energy_s_gradient(accuracy, problem):
    positions = problem.nodes + 0.002 * np.random.default_rng(1).normal(size=problem.nodes.shape)
    differences = np.zeros_like(positions)
    step = 1e-7
    for index in np.ndindex(positions.shape):
        moved = [positions.copy(), positions.copy()]
        moved[0][index] -= step
        moved[1][index] += step
        differences[index] = (stvk_energy(problem, moved[1]) - stvk_energy(problem, moved[0])) / (2.0 * step)
    force = accuracy.internal_force(problem, positions)
    assert np.abs(force - differences).max() < 1e-6 * np.abs(force).max()


def test_a_free_fall_has_no_residual_and_a_wrong_one_has(accuracy, problem):
    positions = free_fall(problem)
    assert accuracy.relative_residual(problem, positions) < 1e-10
    positions[-1] += 0.1 * (positions[-1] - positions[-2])
    assert accuracy.relative_residual(problem, positions) > 1e-2


def test_deviation_compares_the_last_common_step(accuracy, problem):
    reference = free_fall(problem)
    found = accuracy.deviation(problem, problem.nodes + 1.5 * (reference[:3] - problem.nodes), reference)
    assert found["tip_deviation"] == pytest.approx(0.5)
    assert found["node_deviation"] == pytest.approx(0.5)
    assert found["tip_reference_mm"] == pytest.approx(1e3 * np.linalg.norm(reference[2, 4] - problem.nodes[4]))


def test_a_problem_is_read_as_it_was_written(accuracy, problem, tmp_path):
    problem.write(tmp_path / "problem.npz")
    read = accuracy.StepProblem.read(tmp_path / "problem.npz")
    assert read.step_count == 4
    assert read.mesh == ""
    np.testing.assert_array_equal(read.tets, problem.tets)
    assert read.node_masses.sum() == pytest.approx(problem.node_masses.sum())
    volume = sum(abs(np.linalg.det(problem.nodes[t[1:]] - problem.nodes[t[0]])) / 6.0 for t in problem.tets)
    assert read.node_masses.sum() == pytest.approx(1000.0 * volume)
