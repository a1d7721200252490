"""Weight of every quadratic domain at every node, four ways (Luo 2017, section 7, Fig. 7 left).

principal: seed j is moved along its principal direction p, along which it gives way most, while every other
    seed and the ground are held along p only and may slide across it; the weight is the displacement along p.
fixed: the same with other seeds and ground held in all components, which the paper calls over-damped.
perpendicular: as principal, but along the least deformable direction, perpendicular to p.
harmonic: harmonic coordinates, the solution of Laplace's equation that is 1 on the seed, 0 on other seeds and
    the ground.

Departures from the paper: the attached nodes are anchors, and with `ground_blending` the ground they stand for
counts as one more domain whose coordinates are zero: weights are clipped to [0, 1] and divided by max(1, sum), so
that they never exceed a partition of unity and attached nodes do not move. A seed is a footprint, not
a node. The response to a load on a footprint still has a cusp there, and valleys at the other seeds,
whose slope turns small elements inside out when the tongue moves far; so the weights are diffused over
`DIFFUSION_LENGTH`, which costs the interpolation property that sensor constraints make superfluous
(docs/design/domain_weights.md has the measurements).
"""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from ..model import LingualError, TongueModel
from ..model.discretisation import Discretisation
from ..model.sparse_factor import factorise
from .laplacian import laplacian
from .progress import Progress, silent
from .seed_response import SeedResponse
from .seeds import Seed

WEIGHTINGS = ("principal", "fixed", "perpendicular", "harmonic")
DIFFUSION_LENGTH = 3e-3
"""Distance [m] over which one of the two diffusion steps smooths: the size of a coil."""
DIFFUSION_STEPS = 2


def domain_weights(
    tongue: TongueModel,
    seeds: list[Seed],
    weighting: str = "principal",
    ground_blending: bool = True,
    diffusion_length: float = DIFFUSION_LENGTH,
    progress: Progress = silent,
) -> NDArray[np.float64]:
    """Weights (node_count, domain_count), zero at fixed nodes, as a simulation uses them.

    In [0, 1] with rows that sum to one or less when blended with the ground. Raises LingualError for a
    weighting that there is not.
    """
    raw = raw_weights(tongue, seeds, weighting, progress)
    return treated(tongue, raw, ground_blending, diffusion_length)


def raw_weights(
    tongue: TongueModel,
    seeds: list[Seed],
    weighting: str = "principal",
    progress: Progress = silent,
    response: SeedResponse | None = None,
) -> NDArray[np.float64]:
    """Weights (node_count, domain_count) as the equations give them: 1 on their own seed, 0 on the others and
    the ground. Elastostatic ones may leave [0, 1] elsewhere.

    response: of the same seeds, where it is at hand (`rest_response`).
    """
    if weighting not in WEIGHTINGS:
        raise LingualError(f"There is no weighting '{weighting}'; choose one of {', '.join(WEIGHTINGS)}.")
    progress("domain weights", 0.0)
    if weighting == "harmonic":
        raw = harmonic_weights(tongue, seeds)
    else:
        raw = _elastostatic_weights(response or rest_response(tongue, seeds), len(seeds), weighting, progress)
    progress("domain weights", 1.0)
    return raw


def _elastostatic_weights(
    response: SeedResponse, domain_count: int, weighting: str, progress: Progress
) -> NDArray[np.float64]:
    columns = []
    for j in range(domain_count):
        least, _, principal = response.directions(j)
        if weighting == "fixed":
            columns.append(response.with_anchors_fixed(j, principal))
        else:
            columns.append(response.with_anchors_sliding(j, principal if weighting == "principal" else least))
        progress("domain weights", (j + 1) / (domain_count + 1))
    return np.stack(columns, axis=1)


def rest_response(tongue: TongueModel, seeds: list[Seed]) -> SeedResponse:
    """Linear responses of the tongue at rest to its seeds."""
    discretisation = Discretisation(tongue.mesh, tongue.material)
    discretisation.set_displacement(np.zeros((tongue.mesh.node_count, 3)))
    return SeedResponse(discretisation.stiffness().tocsr(), seeds, tongue.fixed_nodes)


def harmonic_weights(tongue: TongueModel, seeds: list[Seed]) -> NDArray[np.float64]:
    """Solutions (node_count, domain_count) of Laplace's equation between seeds and ground, no flux elsewhere."""
    node_count = tongue.mesh.node_count
    weights = np.zeros((node_count, len(seeds)))
    for j, seed in enumerate(seeds):
        weights[seed.nodes, j] = 1.0
    held = np.concatenate([*(seed.nodes for seed in seeds), tongue.fixed_nodes])
    interior = np.setdiff1d(np.arange(node_count), held)
    operator = laplacian(tongue.mesh)[interior]
    weights[interior] = factorise(operator[:, interior]).solve(-(operator @ weights))
    return weights


def treated(
    tongue: TongueModel, raw: NDArray[np.float64], ground_blending: bool, diffusion_length: float
) -> NDArray[np.float64]:
    """Raw weights, blended with the ground if so wished, then diffused over a length [m], 0 for not at all."""
    weights = blend_with_ground(raw, tongue.fixed_nodes) if ground_blending else raw
    if diffusion_length > 0.0:
        weights = diffuse(tongue, weights, diffusion_length)
    return np.clip(weights, 0.0, 1.0) if ground_blending else weights


def blend_with_ground(raw: NDArray[np.float64], fixed_nodes: NDArray[np.int64]) -> NDArray[np.float64]:
    """Clips to [0, 1] and divides rows by max(1, sum); the missing part of each row is the ground's."""
    weights = np.clip(raw, 0.0, 1.0)
    weights[fixed_nodes] = 0.0
    return weights / np.maximum(1.0, weights.sum(axis=1, keepdims=True))


def diffuse(tongue: TongueModel, weights: NDArray[np.float64], length: float) -> NDArray[np.float64]:
    """Implicit diffusion steps (V + l^2 L) w' = V w with natural boundary, zero at the fixed nodes.

    V: node volumes, L: the linear-element Laplacian, l: `length` [m]. The steps average, so that bounds are
    kept as far as the mesh's angles allow.
    """
    mesh, free = tongue.mesh, tongue.free_nodes
    volume = sp.diags_array(mesh.node_volumes[free])
    factor = factorise(volume + length**2 * laplacian(mesh)[free][:, free])
    smooth = np.zeros_like(weights)
    smooth[free] = weights[free]
    for _ in range(DIFFUSION_STEPS):
        smooth[free] = factor.solve(volume @ smooth[free])
    return smooth
