"""Vibration modes of a tongue whose fixed nodes are held: K phi = omega^2 M phi (Yang 2013, section 4); cached.

K is the stiffness at rest and M the lumped mass, so the problem is made a standard one, A y = omega^2 y with
A = M^(-1/2) K M^(-1/2) and phi = M^(-1/2) y. Its lowest eigenpairs come from Lanczos iteration on A^-1 (shift and
invert at zero) with a sparse factor of K.

Departure from the paper: it holds five anchor nodes by Lagrange multipliers on free modes; here the attached
nodes are held in the modes themselves, so that they never move and need no multiplier.
"""


import numpy as np
import scipy.linalg
import scipy.sparse as sp
import scipy.sparse.linalg as sla
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from ..model import LingualError, TongueModel
from ..model.discretisation import Discretisation
from ..model.modal_model import ModalModel
from ..model.sparse_factor import factorise
from .cache import Arrays, cached
from .keys import body_key
from .progress import Progress, silent

ALGORITHM_VERSION = 1
"""Part of the cache key: raise it when the modes change."""
MODE_COUNT = 100
"""Yang 2013 takes as many."""
DENSE_RATIO = 4
"""With fewer unknowns than so many a mode, a dense eigensolver is faster than Lanczos iteration."""
RIGID = 1e-12
"""An eigenvalue below so much of the stiffest node's is no vibration but rounding."""
SOLVES_PER_MODE = 4.0
"""About how many solutions with K Lanczos iteration needs; the progress bar is told in them."""


def build_modal_model(
    tongue: TongueModel, mode_count: int = MODE_COUNT, progress: Progress = silent
) -> ModalModel:
    """The `mode_count` lowest modes of a tongue, from the cache when they are there.

    Raises LingualError when the mesh has fewer degrees of freedom than modes are asked for, or does not hold
    together.
    """
    freedom = 3 * len(tongue.free_nodes)
    if not 1 <= mode_count <= freedom:
        raise LingualError(
            f"{mode_count} modes were asked for, but '{tongue.name}' has {freedom} degrees of freedom: "
            f"ask for 1 to {freedom} modes."
        )
    key = {
        "algorithm": ALGORITHM_VERSION,
        **body_key(tongue),
        "modes": mode_count,
    }
    with threadpool_limits(limits=1, user_api="blas"):
        arrays = cached("modes", key, lambda: _modes(tongue, mode_count, progress))
    return ModalModel(tongue, arrays["eigenvalues"], arrays["modes"])


def _modes(tongue: TongueModel, count: int, progress: Progress) -> Arrays:
    free = tongue.free_nodes
    discretisation = Discretisation(tongue.mesh, tongue.material, free)
    discretisation.set_displacement(np.zeros((tongue.mesh.node_count, 3)))
    stiffness = discretisation.stiffness().tocsr()
    root_mass = np.sqrt(np.repeat(tongue.node_masses[free], 3))
    progress("modes", 0.0)
    if stiffness.shape[0] < DENSE_RATIO * count:
        scaled = stiffness.toarray() / np.outer(root_mass, root_mass)
        eigenvalues, vectors = scipy.linalg.eigh(scaled, subset_by_index=[0, count - 1])
    else:
        eigenvalues, vectors = _lanczos(tongue, stiffness, root_mass, count, progress)
    if not eigenvalues[0] > RIGID * (stiffness.diagonal() / root_mass**2).max():
        raise _loose(tongue)
    vectors *= np.where(vectors[np.abs(vectors).argmax(axis=0), np.arange(count)] < 0.0, -1.0, 1.0)
    modes = np.zeros((tongue.mesh.node_count, 3, count))
    modes[free] = (vectors / root_mass[:, None]).reshape(len(free), 3, count)
    progress("modes", 1.0)
    return {"eigenvalues": eigenvalues, "modes": modes.reshape(-1, count)}


def _lanczos(
    tongue: TongueModel, stiffness: sp.csr_array, root_mass: NDArray, count: int, progress: Progress
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Lowest eigenpairs of M^(-1/2) K M^(-1/2), ascending: (count,) and (size, count)."""
    try:
        factor = factorise(stiffness)
    except np.linalg.LinAlgError as error:
        raise _loose(tongue) from error
    solves = 0

    def solve(vector: NDArray) -> NDArray:
        nonlocal solves
        solves += 1
        progress("modes", min(solves / (SOLVES_PER_MODE * count), 0.99))
        return root_mass * factor.solve(root_mass * vector.ravel())

    size = stiffness.shape[0]
    inverse = sla.LinearOperator((size, size), matvec=solve, dtype=np.float64)
    start = np.random.default_rng(0).standard_normal(size)  # the same modes every time
    inverted, vectors = sla.eigsh(inverse, count, which="LA", v0=start)
    order = np.argsort(inverted)[::-1]
    return 1.0 / inverted[order], vectors[:, order]


def _loose(tongue: TongueModel) -> LingualError:
    return LingualError(
        f"A part of '{tongue.name}' hangs on no fixed node, so it has no modes of vibration: "
        "fix a node of every part, or remove the loose one."
    )
