"""How near a participant is to the reference, and how well it solved its last step, judged from positions alone.

The residual is that of implicit Euler for StVK, in NumPy and independent of every participant's own code:

    r = M (x_n - 2 x_(n-1) + x_(n-2)) / h^2 + f(x_n) - M g

on the free nodes, in the norm dual to the mass and relative to the largest of its three terms, the measure that
Lingual's solvers stop by.
"""

import numpy as np
from numpy.typing import NDArray
from step_problem import StepProblem


def tip_node(problem: StepProblem) -> int:
    """The node farthest forward."""
    return int(np.argmax(problem.nodes[:, 0]))


def internal_force(problem: StepProblem, positions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Gradient of the StVK energy [N], (node_count, 3), at positions [m], (node_count, 3)."""
    corners = problem.tets
    inverse = np.linalg.inv(problem.nodes[corners[:, 1:]] - problem.nodes[corners[:, :1]])
    F = np.swapaxes(inverse @ (positions[corners[:, 1:]] - positions[corners[:, :1]]), 1, 2)
    E = 0.5 * (np.swapaxes(F, 1, 2) @ F - np.eye(3))
    S = 2.0 * problem.lame_mu * E + problem.lame_lambda * np.trace(E, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    volumes = 1.0 / (6.0 * np.abs(np.linalg.det(inverse)))
    shares = volumes[:, None, None] * (inverse.swapaxes(1, 2) @ np.swapaxes(F @ S, 1, 2)).swapaxes(1, 2)
    force = np.zeros_like(positions)
    for corner in range(3):
        np.add.at(force, corners[:, corner + 1], shares[:, :, corner])
        np.add.at(force, corners[:, 0], -shares[:, :, corner])
    return force


def relative_residual(problem: StepProblem, positions: NDArray[np.float64]) -> float:
    """Of the last step; positions of all steps [m], (step_count, node_count, 3), at least three."""
    x = positions[-3:]
    M = problem.node_masses[:, None]
    terms = [
        M * (x[2] - 2.0 * x[1] + x[0]) / problem.step**2,
        internal_force(problem, x[2]),
        np.broadcast_to(-M * problem.gravity, x[2].shape),
    ]
    free = problem.free

    def dual_norm(force: NDArray[np.float64]) -> float:
        return float(np.linalg.norm(force[free] / np.sqrt(M[free])))

    return dual_norm(np.add.reduce(terms)) / max(dual_norm(term) for term in terms)


def deviation(problem: StepProblem, positions: NDArray[np.float64], reference: NDArray[np.float64]) -> dict[str, float]:
    """Against the reference after the last step that both took: of the tip and of all nodes, relative and in mm.

    Arguments: positions of all steps [m], (step_count, node_count, 3), both.
    """
    tip, last = tip_node(problem), min(len(positions), len(reference)) - 1
    moved, wanted = positions[last] - problem.nodes, reference[last] - problem.nodes
    return {
        "tip_mm": 1e3 * float(np.linalg.norm(moved[tip])),
        "tip_reference_mm": 1e3 * float(np.linalg.norm(wanted[tip])),
        "tip_deviation": float(np.linalg.norm(moved[tip] - wanted[tip]) / np.linalg.norm(wanted[tip])),
        "node_deviation": float(np.linalg.norm(moved - wanted) / np.linalg.norm(wanted)),
        "node_deviation_mm": 1e3 * float(np.linalg.norm(moved - wanted, axis=1).mean()),
    }
