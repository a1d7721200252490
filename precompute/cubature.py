"""Cubature elements and weights by greedy non-negative least squares (An, Kim and James 2008).

Given poses Q_t, the reduced internal force is f_t = sum_e V_e g_e(Q_t). A few elements S with weights
w >= 0 are sought such that sum_S w_e g_e(Q_t) = f_t for all t, each pose scaled by 1/|f_t|. Greedily, the
candidates whose contribution points best along the residual join S, a few at a time, then the weights
of S are solved again and elements whose weight comes out negative leave (they may join again).

With many domains a pose has more equations than are needed to tell a few thousand weights apart. Beyond
TRAINING_ROWS in all, each pose's force is projected on random orthonormal directions of its columns, which keep
lengths in the mean (Johnson and Lindenstrauss 1984), so that time and memory do not grow with the domains.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from ..model import ReducedModel, TongueModel
from ..model.reduced_forces import ReducedForces
from ..model.reduced_model import gradient_operator
from .progress import Progress, silent

CANDIDATES = 4000
IMPORTANCE_POSES = 20
NEGLIGIBLE = 1e-6
"""Share of the greatest importance below which an element is not a candidate."""
IMPORTANCE_FLOOR = 0.2
"""Share of the mean importance given to every element, so that none is excluded."""
TRAINING_ROWS = 18_000
"""Equations at most, of all poses together: those of 120 poses and five domains."""
BATCH = 10
"""Elements that join between two solutions of the weights, or a hundredth of all that may."""
ROUNDS_PER_BATCH = 3
"""Rounds allowed for each batch: an element whose weight falls to zero leaves and may be replaced."""
GRAM_SHIFT = 1e-5
"""Added to the unit diagonal of the normal equations: their products are taken in float32."""


def select_cubature(
    model: ReducedModel,
    poses: NDArray[np.float64],
    element_count: int,
    tolerance: float,
    rng: np.random.Generator,
    progress: Progress = silent,
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Element indices and weights [m^3], at most `element_count` of them, all weights positive.

    poses: (pose_count, columns, 3). Stops early when the relative training error is below `tolerance`.
    """
    tongue = model.tongue
    candidates = _draw_candidates(tongue, model, poses, rng)
    columns, target = _training_system(model, poses, candidates, rng, progress)
    chosen, weights = _greedy_nnls(columns, target, element_count, tolerance, progress)
    return candidates[chosen], weights


def _draw_candidates(
    tongue: TongueModel, model: ReducedModel, poses: NDArray[np.float64], rng: np.random.Generator
) -> NDArray[np.int64]:
    """Elements drawn by how much they contribute to the reduced force over some of the poses.

    Drawing by volume would miss the small elements under the sensors, where the force concentrates.
    """
    operator = gradient_operator(tongue, model.basis, np.arange(tongue.mesh.tet_count))
    forces = ReducedForces(tongue.material, operator, tongue.mesh.volumes)
    stacked = operator.reshape(tongue.mesh.tet_count, 3, -1).transpose(0, 2, 1)
    squared = np.zeros(tongue.mesh.tet_count)
    for pose in poses[:: max(1, len(poses) // IMPORTANCE_POSES)]:
        forces.set_coordinates(pose)
        total = np.linalg.norm(forces.force())
        contribution = np.matmul(stacked, forces.elements.stress.numpy())
        squared += (np.linalg.norm(contribution, axis=(1, 2)) / total) ** 2
    importance = np.sqrt(squared)
    moving = importance > NEGLIGIBLE * importance.max()  # elements in the ground carry only rounding
    count = min(CANDIDATES, int(moving.sum()))
    probability = np.where(moving, importance + IMPORTANCE_FLOOR * importance.mean(), 0.0)
    return np.sort(
        rng.choice(tongue.mesh.tet_count, count, replace=False, p=probability / probability.sum())
    )


def _training_system(
    model: ReducedModel,
    poses: NDArray[np.float64],
    candidates: NDArray[np.int64],
    rng: np.random.Generator,
    progress: Progress,
) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Per-unit-volume force of each candidate (rows: pose, column or direction, component) and the exact force."""
    tongue, columns = model.tongue, model.column_count
    kept = min(columns, max(1, TRAINING_ROWS // (3 * len(poses))))
    everything = _all_element_forces(tongue, model.basis)
    operator = gradient_operator(tongue, model.basis, candidates)
    unit = ReducedForces(tongue.material, operator, np.ones(len(candidates)))
    system = np.empty((len(poses), 3 * kept, len(candidates)), dtype=np.float32)
    target = np.empty((len(poses), 3 * kept), dtype=np.float32)
    directions = np.eye(columns)
    for t, pose in enumerate(poses):
        progress("cubature training forces", t / len(poses))
        everything.set_coordinates(pose)
        exact = everything.force()
        scale = np.sqrt(columns / kept) / np.linalg.norm(exact)
        if kept < columns:
            directions = np.linalg.qr(rng.standard_normal((columns, kept)))[0]
        projected = operator if kept == columns else operator @ directions
        stacked = projected.reshape(len(candidates), 3, kept)
        unit.set_coordinates(pose)
        unit.elements.evaluate_stress()
        stress = unit.elements.stress.numpy()
        system[t] = scale * np.matmul(stacked.transpose(0, 2, 1), stress).reshape(len(candidates), -1).T
        target[t] = scale * (directions.T @ exact).ravel()
    progress("cubature training forces", 1.0)
    return system.reshape(-1, len(candidates)), target.ravel()


def _greedy_nnls(
    columns: NDArray[np.float32],
    target: NDArray[np.float32],
    element_count: int,
    tolerance: float,
    progress: Progress,
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Sorted column indices and positive weights that approximately minimise |columns w - target|."""
    length = np.linalg.norm(columns, axis=0)
    scaled_target = target / np.linalg.norm(target)
    chosen = np.zeros(0, dtype=np.int64)
    weights = np.zeros(0)
    normal = _NormalEquations(columns / length, scaled_target)
    residual = scaled_target
    batch = max(BATCH, element_count // 100)
    for _ in range(ROUNDS_PER_BATCH * element_count // batch):
        progress("cubature elements", len(chosen) / element_count)
        if len(chosen) == element_count or np.linalg.norm(residual) < tolerance:
            break
        alignment = residual @ normal.columns
        alignment[chosen] = -np.inf
        joining = np.argsort(alignment)[::-1][: min(batch, element_count - len(chosen))]
        chosen = np.concatenate([chosen, joining[alignment[joining] > 0.0]])
        chosen, weights = normal.positive_solution(chosen)
        residual = scaled_target - normal.columns[:, chosen] @ weights.astype(np.float32)
    progress("cubature elements", 1.0)
    order = np.argsort(chosen)
    scale = np.linalg.norm(target) / length[chosen]
    return chosen[order], (weights * scale)[order]


class _NormalEquations:
    """Least squares on growing subsets of unit columns; inner products are taken once a column."""

    def __init__(self, columns: NDArray[np.float32], target: NDArray[np.float32]) -> None:
        self.columns = columns
        self._right = (target @ columns).astype(np.float64)
        self._rows: dict[int, NDArray[np.float64]] = {}

    def _gram(self, chosen: NDArray[np.int64]) -> NDArray[np.float64]:
        new = [c for c in chosen if c not in self._rows]
        if new:
            products = (self.columns[:, new].T @ self.columns).astype(np.float64)
            self._rows.update(zip(new, products, strict=True))
        return np.array([self._rows[c][chosen] for c in chosen])

    def positive_solution(self, chosen: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
        """The columns that stay and their positive weights: those that come out negative leave."""
        while True:
            gram = self._gram(chosen) + GRAM_SHIFT * np.eye(len(chosen))
            weights = cho_solve(cho_factor(gram), self._right[chosen])
            if (weights > 0.0).all():
                return chosen, weights
            chosen = chosen[weights > 0.0]


def relative_force_errors(model: ReducedModel, poses: NDArray[np.float64]) -> NDArray[np.float64]:
    """|f_cubature - f_exact| / |f_exact| at each pose, (pose_count,)."""
    everything = _all_element_forces(model.tongue, model.basis)
    cubature = ReducedForces(model.tongue.material, model.gradient_operator, model.cubature_weights)
    errors = []
    for pose in poses:
        everything.set_coordinates(pose)
        cubature.set_coordinates(pose)
        exact = everything.force()
        errors.append(np.linalg.norm(cubature.force() - exact) / np.linalg.norm(exact))
    return np.array(errors)


def _all_element_forces(tongue: TongueModel, basis: NDArray[np.float64]) -> ReducedForces:
    operator = gradient_operator(tongue, basis, np.arange(tongue.mesh.tet_count))
    return ReducedForces(tongue.material, operator, tongue.mesh.volumes)
