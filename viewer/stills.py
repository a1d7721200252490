"""Shapes of one body that stand still, as a session that the renderer can draw: one frame for each shape."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..model import StateHistory, TongueModel
from ..model.history import Sample
from .session_view import NO_FIELD, ScalarField


@dataclass(frozen=True, eq=False)
class Still:
    """One shape. name: written under it. nodes: (node_count, 3) [m], jaw frame. scalar: its colours, None for
    the tongue's own."""

    name: str
    nodes: NDArray[np.floating]
    scalar: ScalarField | None = None


@dataclass(frozen=True, eq=False)
class PictureRow:
    """Stills of one body. title: written above them. view: built-in view that they are seen from.

    Every distinct colour bar of the stills is drawn once, at the row's right end.
    """

    title: str
    model: TongueModel
    stills: tuple[Still, ...]
    view: str = "lateral"


class StillSession:
    """Implements SessionView over stills: frame k, at k seconds, is the shape of still k; fields are numbered."""

    solver_name = "none"
    failure: str | None = None
    notice: str | None = None

    def __init__(self, model: TongueModel, stills: tuple[Still, ...]) -> None:
        self.model = model
        self.title = model.name
        self.duration = float(len(stills) - 1)
        self.history = StateHistory(model.mesh.node_count, model.sensors.count, len(stills))
        self._scalars = [still.scalar for still in stills]
        for k, still in enumerate(stills):
            sensors = model.sensors.positions(still.nodes)
            self.history.append(float(k), still.nodes, sensors, sensors, np.zeros(3))

    def field_name(self, index: int) -> str:
        """Name of the colours of still `index`."""
        return NO_FIELD if self._scalars[index] is None else str(index)

    def field_names(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys((NO_FIELD, *(self.field_name(k) for k in range(len(self._scalars))))))

    def field(self, name: str, sample: Sample) -> ScalarField:
        scalar = self._scalars[int(name)]
        assert scalar is not None
        return scalar
