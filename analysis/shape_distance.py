"""How far two shapes of one surface are apart: corresponding points, and Hausdorff as in Luo (2017, section 9)."""

from dataclasses import dataclass

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.surface_distance import closest_distance


@dataclass(frozen=True, eq=False)
class Similarity:
    """x -> scale * rotation @ x + translation. rotation: (3, 3); translation: (3,) [m]."""

    scale: float
    rotation: NDArray[np.float64]
    translation: NDArray[np.float64]

    def apply(self, points: NDArray[np.floating]) -> NDArray[np.float64]:
        """Transforms points (n, 3)."""
        return self.scale * points @ self.rotation.T + self.translation


def fitted_similarity(source: NDArray[np.floating], target: NDArray[np.floating]) -> Similarity:
    """The similarity that takes `source` nearest to `target`, both (n, 3), in the least squares sense.

    Umeyama (1991), "Least-squares estimation of transformation parameters between two point patterns"; the shape
    matching of Luo (2017, section 9) is its rotation. Reflections are excluded.
    """
    source_mean, target_mean = source.mean(axis=0), target.mean(axis=0)
    a, b = source - source_mean, target - target_mean
    left, singular, right = np.linalg.svd(b.T @ a)
    sign = np.array([1.0, 1.0, np.sign(np.linalg.det(left) * np.linalg.det(right))])
    rotation = (left * sign) @ right
    scale = float(np.sum(singular * sign) / np.sum(a**2))
    return Similarity(scale, rotation, target_mean - scale * rotation @ source_mean)


def hausdorff_distance(
    a: NDArray[np.floating], b: NDArray[np.floating], triangles: NDArray[np.int32]
) -> float:
    """The larger of the two one-sided distances, each from the vertices of one surface to the other's triangles.

    a, b: (vertex_count, 3) [m], positions of the same vertices; triangles: (triangle_count, 3).
    """
    return max(_one_sided(a, b, triangles), _one_sided(b, a, triangles))


def _one_sided(points: NDArray[np.floating], vertices: NDArray[np.floating], triangles: NDArray[np.int32]) -> float:
    used = np.unique(triangles)
    farthest = float(np.linalg.norm(np.ptp(np.concatenate([points, vertices]), axis=0)))
    surface = wp.Mesh(
        points=wp.array(vertices, dtype=wp.vec3, device="cpu"),
        indices=wp.array(triangles.ravel(), dtype=wp.int32, device="cpu"),
    )
    distance = wp.empty(len(used), dtype=float, device="cpu")
    at: wp.array = wp.array(points[used], dtype=wp.vec3, device="cpu")
    wp.launch(closest_distance, len(used), [surface.id, at, farthest], [distance], device="cpu")
    return float(distance.numpy().max())
