"""The data-driven pressure subspace of a reduced model (Luo 2017, section 8); cached.

Pressures of key frames (key_frames.py) are orthonormalised. The constraints c = P^T V (J - 1) are then summed over the
cubature elements alone, with rows fitted by ridge regression to the exact values and Jacobians of c on some of the key
frames' poses; other poses measure the error. Where there are no recordings, sensor displacements are sampled as they
are for cubature (poses.py).
"""

from dataclasses import asdict, dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from threadpoolctl import threadpool_limits

from ..model import LingualError, ReducedModel, Trajectory
from ..model.volume import COMPLIANCE_LENGTH, ElementVolumes
from ..model.volume_polynomial import volume_coefficients
from ..model.volume_pressure import PressureSubspace, excess_jacobian
from .cache import Arrays, cached, digest
from .key_frames import key_displacements, key_pressures, orthonormal_basis
from .keys import tongue_key
from .poses import sampled_displacements
from .progress import Progress, silent

ALGORITHM_VERSION = 2
"""Part of the cache key: raise it when any step below changes its result."""
FIT_POSES, HELD_OUT_POSES = 30, 8
RIDGE = 1e-5
"""Relative to the mean diagonal of the normal equations."""


@dataclass(frozen=True)
class PressureSettings:
    """What the user may choose.

    key_frame_count: equilibria. mode_count: columns of the basis at most. remainder: a pressure of which less than
    this share (of the largest) is new is left out. compliance_length: of the volume correction [m]. seed: of the
    sampling; the same seed gives the same subspace.
    """

    key_frame_count: int = 100
    mode_count: int = 100
    remainder: float = 0.005
    compliance_length: float = COMPLIANCE_LENGTH
    seed: int = 2017


def build_pressure_subspace(
    model: ReducedModel,
    settings: PressureSettings | None = None,
    recordings: list[Trajectory] | None = None,
    progress: Progress = silent,
) -> PressureSubspace:
    """The pressure subspace of a reduced model, from the cache when it is there.

    recordings: trajectories fitted to the tongue's sensors, of which the key frames are picked; a speaker's, or the
    demonstration. Raises LingualError when too few key frames have an equilibrium.
    """
    settings = settings or PressureSettings()
    recordings = recordings or []
    tongue = model.tongue
    key = {
        "algorithm": ALGORITHM_VERSION,
        **tongue_key(tongue),
        "basis": digest(model.basis),
        "cubature": digest(model.cubature_elements),
        "recordings": [digest(r.time, r.positions) for r in recordings],
        **asdict(settings),
    }
    with threadpool_limits(limits=1, user_api="blas"):
        arrays = cached("pressure", key, lambda: _build(model, settings, recordings, progress))
    return PressureSubspace(
        basis=arrays["basis"],
        cubature_rows=arrays["cubature_rows"],
        cubature_error=float(arrays["cubature_error"]),
        volume_coefficients=arrays["volume_coefficients"],
        key_frame_count=int(arrays["key_frame_count"]),
    )


def _build(
    model: ReducedModel, settings: PressureSettings, recordings: list[Trajectory], progress: Progress
) -> Arrays:
    rng = np.random.default_rng(settings.seed)
    tongue = model.tongue
    rest = tongue.sensor_rest_positions
    displacements = key_displacements(recordings, rest, settings.key_frame_count)
    missing = settings.key_frame_count - len(displacements)
    displacements = np.concatenate([displacements, sampled_displacements(rest, missing, rng)])
    poses, pressures = key_pressures(model, displacements, settings.compliance_length, rng, progress)
    if len(poses) < 2 * HELD_OUT_POSES:
        raise LingualError(
            f"Only {len(poses)} of {len(displacements)} key frames of '{tongue.name}' have an equilibrium: "
            "check the mesh's unit, its fixed nodes and its sensors."
        )
    basis = orthonormal_basis(pressures, tongue.mesh.volumes, settings.mode_count, settings.remainder)
    order = rng.permutation(len(poses))
    held_out, training = poses[order[:HELD_OUT_POSES]], poses[order[HELD_OUT_POSES:][:FIT_POSES]]
    rows = _fitted_rows(model, basis, training, progress)
    return {
        "basis": basis,
        "cubature_rows": rows,
        "cubature_error": np.array(_jacobian_error(model, basis, rows, held_out)),
        "volume_coefficients": volume_coefficients(tongue.mesh, model.basis),
        "key_frame_count": np.array(len(poses)),
    }


class _ExactConstraints:
    """c = P^T V (J - 1) and its Jacobian over all elements of the mesh."""

    def __init__(self, model: ReducedModel, basis: NDArray[np.float64]) -> None:
        self._model, self._basis = model, basis
        self._free_basis = model.basis[model.tongue.free_nodes]
        self._elements = ElementVolumes(model.tongue.mesh, model.tongue.free_nodes)

    def at(self, pose: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """c (modes,) and dc/dQ (modes, 3 columns) at coordinates (columns, 3)."""
        mesh = self._model.tongue.mesh
        self._elements.set_positions(mesh.nodes + self._model.basis @ pose)
        nodal = (self._elements.divergence.T @ self._basis).reshape(len(self._free_basis), -1)
        jacobian = (self._free_basis.T @ nodal).reshape(3 * self._model.column_count, -1)
        return self._basis.T @ (self._elements.volumes - mesh.volumes), jacobian.T


def _fitted_rows(
    model: ReducedModel, basis: NDArray[np.float64], poses: NDArray[np.float64], progress: Progress
) -> NDArray[np.float64]:
    """Rows (modes, cubature_count) with rows @ (J - 1) close to c, and its Jacobian too, on the poses.

    The Jacobians at a pose count as much as the values there.
    """
    operator = model.gradient_operator
    exact = _ExactConstraints(model, basis)
    count = len(model.cubature_elements)
    normal, right = np.zeros((count, count)), np.zeros((count, basis.shape[1]))
    for n, pose in enumerate([np.zeros((model.column_count, 3)), *poses]):
        progress("pressure rows", n / (len(poses) + 1))
        value, jacobian = exact.at(pose)
        element_jacobian = excess_jacobian(operator, pose)
        scale = 1.0 / np.sum(element_jacobian**2)
        normal += scale * element_jacobian @ element_jacobian.T
        right += scale * element_jacobian @ jacobian.T
        excess = _excess(operator, pose)
        if excess.any():  # not at rest, nor where a motion pauses
            scale = 1.0 / np.sum(excess**2)
            normal += scale * np.outer(excess, excess)
            right += scale * np.outer(excess, value)
    progress("pressure rows", 1.0)
    normal += RIDGE * np.trace(normal) / count * np.eye(count)
    rows: NDArray[np.float64] = cho_solve(cho_factor(normal), right).T
    return np.ascontiguousarray(rows)


def _excess(operator: NDArray[np.float64], pose: NDArray[np.float64]) -> NDArray[np.float64]:
    """det F - 1 of the cubature elements at a pose."""
    return np.linalg.det(np.eye(3) + (operator @ pose).reshape(-1, 3, 3)) - 1.0


def _jacobian_error(
    model: ReducedModel, basis: NDArray[np.float64], rows: NDArray[np.float64], poses: NDArray[np.float64]
) -> float:
    """Relative error of dc/dQ, root mean square over the poses."""
    exact = _ExactConstraints(model, basis)
    squares = []
    for pose in poses:
        _, jacobian = exact.at(pose)
        fitted = rows @ excess_jacobian(model.gradient_operator, pose)
        squares.append(np.sum((fitted - jacobian) ** 2) / np.sum(jacobian**2))
    return float(np.sqrt(np.mean(squares)))
