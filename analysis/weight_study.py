"""Domain weights compared by what they cost a bend (Luo 2017, section 7, Fig. 7 left).

Each weighting gives a subspace; the body is bent in it and in full space under the same load, with all elements
integrated so that cubature plays no part. Every weighting is taken as its equations give it ("raw"), blended
with the ground, and blended and diffused, which is how a simulation uses it (precompute/domain_weights.py).
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import TongueModel
from ..precompute.basis import blended_quadratic_basis
from ..precompute.domain_weights import DIFFUSION_LENGTH, WEIGHTINGS, raw_weights, rest_response, treated
from ..precompute.partition import flooded_partition
from ..precompute.progress import Progress, silent
from ..precompute.seeds import FOOTPRINT_RADIUS, Seed, choose_seeds
from .cantilever import DOMAIN_COUNT, SEED_RADIUS, load_end_cantilever
from .static_bend import Bend, Equilibrium, bent, scaled_bend

TREATMENTS = {"raw": (False, 0.0), "blended": (True, 0.0), "diffused": (True, DIFFUSION_LENGTH)}
"""What is done to raw weights: blended with the ground or not, and the length of diffusion [m]."""

TIP_RADIUS = 8e-3
"""[m]. A tongue is bent by a load on what is this near to its foremost sensor."""
TONGUE_REACH = 12e-3
"""Displacement of a tongue's tip in linear elasticity [m]."""


@dataclass(frozen=True, eq=False)
class WeightTrial:
    """One weighting with one treatment against the full space.

    weights: (node_count, domain_count). equilibrium: in their subspace. Errors are relative: displacement_error
    in the mass norm, tip_error of the tip's mean displacement, energy_error of the least potential energy,
    which a subspace can only miss upwards.
    """

    weighting: str
    treatment: str
    weights: NDArray[np.float64]
    equilibrium: Equilibrium
    displacement_error: float
    tip_error: float
    energy_error: float


@dataclass(frozen=True, eq=False)
class WeightStudy:
    """All trials of one body.

    seeds: of its domains. partition: domain of every node, (node_count,). full: its bend in full space.
    """

    bend: Bend
    seeds: list[Seed]
    partition: NDArray[np.int64]
    full: Equilibrium
    trials: list[WeightTrial]

    def trial(self, weighting: str, treatment: str) -> WeightTrial:
        return next(t for t in self.trials if (t.weighting, t.treatment) == (weighting, treatment))


def tongue_bend(tongue: TongueModel) -> Bend:
    """The tongue with its tip lifted by a load on the tissue around the foremost sensor, in proportion to mass."""
    foremost = tongue.sensor_rest_positions[tongue.sensor_rest_positions[:, 0].argmax()]
    near = np.linalg.norm(tongue.mesh.nodes - foremost, axis=1) < TIP_RADIUS
    near[tongue.fixed_nodes] = False
    load = np.zeros_like(tongue.mesh.nodes)
    load[near, 2] = tongue.node_masses[near]
    return scaled_bend(tongue.name, tongue, load, np.flatnonzero(near), TONGUE_REACH)


def study_cantilever(progress: Progress = silent) -> WeightStudy:
    """The load-end cantilever with three domains."""
    return study_weights(load_end_cantilever(), DOMAIN_COUNT, SEED_RADIUS, progress)


def study_weights(
    bend: Bend, domain_count: int, footprint_radius: float = FOOTPRINT_RADIUS, progress: Progress = silent
) -> WeightStudy:
    """Every weighting with every treatment on one bend. Raises LingualError for a domain count that does not fit."""
    tongue = bend.tongue
    seeds = choose_seeds(tongue, domain_count, footprint_radius)
    full = bent(bend)
    response = rest_response(tongue, seeds)
    trials: list[WeightTrial] = []
    stage = f"weights of {bend.name}"
    for weighting in WEIGHTINGS:
        raw = raw_weights(tongue, seeds, weighting, response=response)
        for treatment in TREATMENTS:
            progress(stage, len(trials) / (len(WEIGHTINGS) * len(TREATMENTS)))
            trials.append(_trial(bend, seeds, full, raw, weighting, treatment))
    progress(stage, 1.0)
    partition = flooded_partition(tongue.mesh, [seed.nodes for seed in seeds])
    return WeightStudy(bend, seeds, partition, full, trials)


def _trial(
    bend: Bend, seeds: list[Seed], full: Equilibrium, raw: NDArray[np.float64], weighting: str, treatment: str
) -> WeightTrial:
    weights = treated(bend.tongue, raw, *TREATMENTS[treatment])
    reduced = bent(bend, blended_quadratic_basis(bend.tongue, seeds, weights))
    masses = bend.tongue.node_masses[:, None]

    def size(displacement: NDArray[np.float64]) -> float:
        return float(np.sqrt(np.sum(masses * displacement**2)))

    tip, full_tip = (bend.tip_displacement(e.displacement) for e in (reduced, full))
    return WeightTrial(
        weighting=weighting,
        treatment=treatment,
        weights=weights,
        equilibrium=reduced,
        displacement_error=size(reduced.displacement - full.displacement) / size(full.displacement),
        tip_error=float(np.linalg.norm(tip - full_tip) / np.linalg.norm(full_tip)),
        energy_error=(reduced.potential - full.potential) / abs(full.potential),
    )
