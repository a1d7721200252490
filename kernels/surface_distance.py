"""Distance of points from a triangle surface, by Warp's bounding volume hierarchy."""

import warp as wp


@wp.kernel(module="unique")
def closest_distance(
    surface: wp.uint64,
    points: wp.array(dtype=wp.vec3),
    farthest: float,
    distance_out: wp.array(dtype=float),
):
    """One thread writes one point's distance from the surface, `farthest` when nothing is nearer."""
    n = wp.tid()
    query = wp.mesh_query_point_no_sign(surface, points[n], farthest)
    distance_out[n] = farthest
    if query.result:
        closest = wp.mesh_eval_position(surface, query.face, query.u, query.v)
        distance_out[n] = wp.length(points[n] - closest)
