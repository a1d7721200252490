"""Scalar fields over the tongue for display: displacement, strain energy, volume change, contact, domains."""

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..model import ReducedModel, RigidPose, TongueModel
from ..model.contact_depth import SurfacePenetration
from ..model.discretisation import Discretisation
from ..model.history import Sample
from ..precompute.partition import flooded_partition, nearest_nodes
from ..precompute.signed_distance import signed_distance_grids
from ..viewer.session_view import NO_FIELD, ScalarField

DISPLACEMENT = "displacement"
STRAIN_ENERGY = "strain energy"
DET_F = "det F"
CONTACT = "contact depth"
DOMAIN = "domain"
DOMAIN_PREFIX = "domain weight "


class FieldSource:
    """Evaluates the named fields of one tongue; domain weights only when there is a reduced model."""

    def __init__(self, tongue: TongueModel, reduced: ReducedModel | None = None) -> None:
        self._tongue = tongue
        self._reduced = reduced
        self._discretisation = Discretisation(tongue.mesh, tongue.material)

    def names(self) -> tuple[str, ...]:
        fields = (NO_FIELD, DISPLACEMENT, STRAIN_ENERGY, DET_F, *([CONTACT] if self._tongue.rigid else []))
        if self._reduced is None:
            return fields
        return (*fields, DOMAIN, *(DOMAIN_PREFIX + d for d in self._reduced.domain_names))

    def field(self, name: str, sample: Sample) -> ScalarField:
        """The field at one sample. Raises KeyError for a name that `names` does not list."""
        if name == DISPLACEMENT:
            distance = np.linalg.norm(sample.nodes - self._tongue.mesh.nodes, axis=1)
            return ScalarField(DISPLACEMENT, 1e3 * distance, "mm", (0.0, 15.0))
        if name in (STRAIN_ENERGY, DET_F):
            density, det_f = self._elements(sample)
            if name == STRAIN_ENERGY:
                return ScalarField("strain energy density", self._at_nodes(density), "J/m³", (0.0, 1500.0))
            return ScalarField(DET_F, self._at_nodes(det_f), "", (0.8, 1.2), centre=1.0)
        if name == CONTACT and self._tongue.rigid:
            depths = self._penetration.depths(sample.nodes, RigidPose(translation=sample.jaw_translation))
            return ScalarField(CONTACT, depths, "mm", (0.0, 0.5))
        if self._reduced and name == DOMAIN:
            names = self._reduced.domain_names
            return ScalarField(DOMAIN, self._partition, "", (0.0, len(names) - 1.0), categories=names)
        if self._reduced and name.startswith(DOMAIN_PREFIX):
            domain = self._reduced.domain_names.index(name.removeprefix(DOMAIN_PREFIX))
            return ScalarField(name, self._reduced.domain_weights[:, domain], "", (0.0, 1.0))
        raise KeyError(name)

    @cached_property
    def _penetration(self) -> SurfacePenetration:
        return SurfacePenetration(self._tongue, signed_distance_grids(self._tongue))

    @cached_property
    def _partition(self) -> NDArray[np.int64]:
        """Domain of every node, (node_count,)."""
        assert self._reduced is not None
        mesh = self._tongue.mesh
        return flooded_partition(mesh, nearest_nodes(mesh, self._reduced.seeds))

    def _elements(self, sample: Sample) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
        self._discretisation.set_displacement(sample.nodes.astype(np.float64) - self._tongue.mesh.nodes)
        return self._discretisation.elements.energy_density()

    def _at_nodes(self, values: NDArray[np.floating]) -> NDArray[np.floating]:
        """Volume-weighted mean over the elements around each node."""
        mesh = self._tongue.mesh
        quarter = np.repeat(values * mesh.volumes / 4.0, 4)
        return np.bincount(mesh.tets.ravel(), weights=quarter, minlength=mesh.node_count) / mesh.node_volumes
