"""A tongue ready to be simulated: mesh, attachment, sensors, skin and the rigid mouth around it."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from .errors import LingualError
from .material import Material
from .sensors import SensorLayout
from .surface import EmbeddedSurface, RigidSurface
from .tet_mesh import TetMesh


@dataclass(frozen=True, eq=False)
class TongueModel:
    """Everything about a tongue that does not change with time.

    name: how reports call it.
    mesh: rest shape, jaw frame [m].
    fixed_nodes: sorted indices of the nodes held by bone (hyoid, genial tubercle), (fixed_count,) int64.
    sensors: the coils on the midline.
    skin: the display surface.
    rigid: jaw, teeth, palate; may be empty.
    material: constitutive parameters.

    Raises LingualError when no node is fixed or an index is out of range.
    """

    name: str
    mesh: TetMesh
    fixed_nodes: NDArray[np.int64]
    sensors: SensorLayout
    skin: EmbeddedSurface
    rigid: tuple[RigidSurface, ...] = ()
    material: Material = field(default_factory=Material)

    def __post_init__(self) -> None:
        fixed = np.unique(np.asarray(self.fixed_nodes, dtype=np.int64))
        object.__setattr__(self, "fixed_nodes", fixed)
        if len(fixed) < 3:
            raise LingualError(
                f"Tongue '{self.name}' has {len(fixed)} fixed nodes; at least 3 must be held by bone."
            )
        if fixed[0] < 0 or fixed[-1] >= self.mesh.node_count:
            raise LingualError(
                f"Tongue '{self.name}' fixes node {fixed[-1] if fixed[-1] >= self.mesh.node_count else fixed[0]}, "
                f"but the mesh's nodes are 0 to {self.mesh.node_count - 1}."
            )

    @cached_property
    def free_nodes(self) -> NDArray[np.int64]:
        """Sorted indices of the nodes that move, (node_count - fixed_count,)."""
        return np.setdiff1d(np.arange(self.mesh.node_count), self.fixed_nodes)

    @cached_property
    def node_masses(self) -> NDArray[np.float64]:
        """Lumped mass of each node [kg], (node_count,)."""
        return self.material.density * self.mesh.node_volumes

    @cached_property
    def sensor_rest_positions(self) -> NDArray[np.float64]:
        """Sensor positions at rest [m], (sensor_count, 3), jaw frame."""
        return self.sensors.positions(self.mesh.nodes)
