"""Where the quadratic domains sit: at the sensors, at the mass centre, then as far apart as possible.

Luo (2017, section 7) has five. With as many domains as sensors the mass centre is left out.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ..model import LingualError, TongueModel

FOOTPRINT_RADIUS = 2.0e-3
"""Radius [m] of the nodes that act as one seed: a coil's footprint, 3 to 4 mm across."""

MINIMUM_FOOTPRINT = 4
"""Nodes of a footprint at least, on meshes too coarse for its radius."""


@dataclass(frozen=True, eq=False)
class Seed:
    """One domain's seed. name; nodes: its footprint (indices); centre: their mean [m], (3,)."""

    name: str
    nodes: NDArray[np.int64]
    centre: NDArray[np.float64]


def choose_seeds(
    tongue: TongueModel, domain_count: int, footprint_radius: float = FOOTPRINT_RADIUS
) -> list[Seed]:
    """Seeds at the sensors and the mass centre (Luo 2017, section 7), the rest by farthest points.

    footprint_radius: [m]; 0 for the nearest node alone, as in the paper.

    Raises LingualError for fewer domains than sensors, or more than the mesh has room for.
    """
    if domain_count < tongue.sensors.count:
        raise LingualError(
            f"{domain_count} domains are too few: the sensors need {tongue.sensors.count}; ask for more."
        )
    nodes = tongue.mesh.nodes
    tree = cKDTree(nodes)
    centre = np.average(nodes, axis=0, weights=tongue.node_masses)
    points = [*tongue.sensor_rest_positions, centre]
    names = [*tongue.sensors.names, "centre"]
    taken = tongue.fixed_nodes
    seeds: list[Seed] = []
    while len(seeds) < domain_count:
        if len(points) == len(seeds):
            points.append(_farthest_node(nodes, tongue, np.array([s.centre for s in seeds])))
            names.append(f"D{len(names) + 1}")
        footprint = np.setdiff1d(_footprint(tree, points[len(seeds)], footprint_radius), taken)
        if len(footprint) == 0:
            raise LingualError(f"The mesh of '{tongue.name}' has no room for {domain_count} domains; ask for fewer.")
        taken = np.union1d(taken, footprint)
        seeds.append(Seed(names[len(seeds)], footprint, nodes[footprint].mean(axis=0)))
    return seeds


def _footprint(tree: cKDTree, point: NDArray[np.float64], radius: float) -> NDArray[np.int64]:
    inside = tree.query_ball_point(point, radius)
    nearest = tree.query(point, k=MINIMUM_FOOTPRINT if radius > 0.0 else 1)[1]
    return np.union1d(inside, nearest).astype(np.int64)


def _farthest_node(nodes: NDArray[np.float64], tongue: TongueModel, centres: NDArray) -> NDArray[np.float64]:
    """The free node farthest from all centres and from the ground."""
    free = tongue.free_nodes
    to_seed = cKDTree(centres).query(nodes[free])[0]
    to_ground = cKDTree(nodes[tongue.fixed_nodes]).query(nodes[free])[0]
    return nodes[free[np.argmax(np.minimum(to_seed, to_ground))]]
