"""What of a tongue the cached results depend on, as parts of `cache.cached`'s keys."""

from dataclasses import asdict

from ..model import TongueModel
from .cache import digest


def body_key(tongue: TongueModel) -> dict[str, object]:
    """Mesh, attachment and material."""
    return {
        "mesh": digest(tongue.mesh.nodes, tongue.mesh.tets, tongue.fixed_nodes),
        "material": asdict(tongue.material),
    }


def tongue_key(tongue: TongueModel) -> dict[str, object]:
    """Mesh, attachment, material and sensors."""
    return {**body_key(tongue), "sensors": digest(tongue.sensors.weights.toarray())}
