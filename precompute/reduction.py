"""From a tongue to its reduced model: seeds, weights, basis, training poses, cubature; cached."""

from dataclasses import asdict, dataclass, replace

import numpy as np
from threadpoolctl import threadpool_limits

from ..model import LingualError, ReducedModel, TongueModel, Trajectory
from .basis import blended_quadratic_basis
from .cache import Arrays, cached, digest
from .cubature import relative_force_errors, select_cubature
from .domain_weights import DIFFUSION_LENGTH, domain_weights
from .keys import tongue_key
from .poses import equilibrium_poses, recorded_displacements, sampled_displacements
from .progress import Progress, silent
from .seeds import FOOTPRINT_RADIUS, choose_seeds

ALGORITHM_VERSION = 8
"""Part of the cache key: raise it when any step below changes its result."""


@dataclass(frozen=True)
class ReductionSettings:
    """What the user may choose.

    domain_count: quadratic domains (sensors, mass centre, then farthest points), 4 to 40 or so.
    footprint_radius: size of a domain's seed [m].
    weighting: how domain weights are found, one of domain_weights.WEIGHTINGS. ground_blending: whether the
        ground counts as a domain; diffusion_length: over which the weights are smoothed [m]. The paper's raw
        weights are "principal" without blending and with a length of 0.
    cubature_per_domain: elements at most, for each of five domains; `cubature_limit` says for how many in all.
    cubature_tolerance: relative training error that is good enough
        (held-out poses come out a little worse; the default keeps them within 5 %).
    pose_count: training poses up to five domains, fewer with more (`training_poses`). seed: of the random
        sampling; the same seed gives the same model.
    """

    domain_count: int = 5
    footprint_radius: float = FOOTPRINT_RADIUS
    weighting: str = "principal"
    ground_blending: bool = True
    diffusion_length: float = DIFFUSION_LENGTH
    cubature_per_domain: int = 200
    cubature_tolerance: float = 0.033
    pose_count: int = 120
    seed: int = 2017

    @property
    def cubature_limit(self) -> int:
        """Elements at most: with the number of domains up to five, with its root beyond.

        Neighbouring domains see the same elements, so the number needed grows more slowly than theirs.
        """
        return round(self.cubature_per_domain * self.domain_count * self._fading)

    @property
    def training_poses(self) -> int:
        """Poses to train on: a pose of more domains is slower to find and says more."""
        return round(self.pose_count * self._fading)

    @property
    def _fading(self) -> float:
        return min(1.0, (FEW_DOMAINS / self.domain_count) ** 0.5)


HELD_OUT_POSES = 40
FEW_DOMAINS = 5
"""Up to so many, training poses and cubature elements are as many as the settings say."""


def build_reduced_model(
    tongue: TongueModel,
    settings: ReductionSettings | None = None,
    recordings: list[Trajectory] | None = None,
    progress: Progress = silent,
) -> ReducedModel:
    """The reduced model of a tongue, from the cache when it is there.

    recordings: trajectories fitted to the tongue's sensors; half of the training poses then come from
    them. Raises LingualError for settings that the mesh cannot satisfy.
    """
    settings = settings or ReductionSettings()
    recordings = recordings or []
    key = {
        "algorithm": ALGORITHM_VERSION,
        **tongue_key(tongue),
        "recordings": [digest(r.positions) for r in recordings],
        **asdict(settings),
    }
    with threadpool_limits(limits=1, user_api="blas"):  # a second thread slows small factorisations tenfold
        arrays = cached("reduction", key, lambda: _reduce(tongue, settings, recordings, progress))
    return _from_arrays(tongue, arrays)


def all_element_model(tongue: TongueModel, domain_count: int = 5, progress: Progress = silent) -> ReducedModel:
    """The reduced model that integrates every element exactly: the reference for cubature."""
    return _exact_model(tongue, ReductionSettings(domain_count=domain_count), progress)


def _exact_model(tongue: TongueModel, settings: ReductionSettings, progress: Progress) -> ReducedModel:
    seeds = choose_seeds(tongue, settings.domain_count, settings.footprint_radius)
    weights = domain_weights(
        tongue, seeds, settings.weighting, settings.ground_blending, settings.diffusion_length, progress
    )
    return ReducedModel(
        tongue=tongue,
        domain_names=tuple(s.name for s in seeds),
        seeds=np.array([s.centre for s in seeds]),
        domain_weights=weights,
        basis=blended_quadratic_basis(tongue, seeds, weights),
        cubature_elements=np.arange(tongue.mesh.tet_count),
        cubature_weights=tongue.mesh.volumes,
        cubature_error=0.0,
    )


def _reduce(
    tongue: TongueModel, settings: ReductionSettings, recordings: list[Trajectory], progress: Progress
) -> Arrays:
    rng = np.random.default_rng(settings.seed)
    exact = _exact_model(tongue, settings, progress)
    rest = tongue.sensor_rest_positions
    recorded = np.zeros((0, *rest.shape))
    if recordings:
        recorded = recorded_displacements(recordings, rest, settings.training_poses // 2)
    sampled = sampled_displacements(rest, settings.training_poses + HELD_OUT_POSES - len(recorded), rng)
    poses = equilibrium_poses(exact, np.concatenate([recorded, sampled]), rng, progress)
    if len(poses) < 2 * HELD_OUT_POSES:
        raise LingualError(
            f"Only {len(poses)} of {len(sampled) + len(recorded)} training poses of '{tongue.name}' have an "
            "equilibrium: check the mesh's unit, its fixed nodes and its sensors."
        )
    if recordings:  # so that recorded and sampled poses are both held out
        poses = rng.permutation(poses)
    training, held_out = poses[:-HELD_OUT_POSES], poses[-HELD_OUT_POSES:]
    elements, weights = select_cubature(
        exact,
        training,
        settings.cubature_limit,
        settings.cubature_tolerance,
        rng,
        progress,
    )
    model = replace(exact, cubature_elements=elements, cubature_weights=weights)
    error = np.sqrt(np.mean(relative_force_errors(model, held_out) ** 2))
    return {
        "domain_names": np.array(model.domain_names),
        "seeds": model.seeds,
        "domain_weights": model.domain_weights,
        "basis": model.basis,
        "cubature_elements": elements,
        "cubature_weights": weights,
        "cubature_error": np.array(error),
    }


def _from_arrays(tongue: TongueModel, arrays: Arrays) -> ReducedModel:
    return ReducedModel(
        tongue=tongue,
        domain_names=tuple(str(n) for n in arrays["domain_names"]),
        seeds=arrays["seeds"],
        domain_weights=arrays["domain_weights"],
        basis=arrays["basis"],
        cubature_elements=arrays["cubature_elements"],
        cubature_weights=arrays["cubature_weights"],
        cubature_error=float(arrays["cubature_error"]),
    )
