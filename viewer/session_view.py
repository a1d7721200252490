"""What the viewer needs to know of a session: the protocol that the application implements."""

from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..model import StateHistory, TongueModel
from ..model.history import Sample

CATEGORY_COUNT = 256
"""Colours there are for categories: as many as a colour table has."""

NO_FIELD = "none"
"""The field name that stands for the tongue's own colours."""


@dataclass(frozen=True, eq=False)
class ScalarField:
    """A scalar over the mesh at one time, to be drawn in colour.

    label: quantity, as written over the colour bar, e.g. "displacement".
    values: (node_count,) in `unit`.
    unit: e.g. "mm", "J/m³"; empty for a number without unit.
    limits: (low, high) of the colour map in `unit`, the same at every time so that colours compare.
    centre: the value in the middle of a diverging map; None selects a sequential map.
    categories: names of what the values 0, 1, 2, ... stand for, each with a colour of its own that is not mixed
        with its neighbours'; empty for a quantity.
    """

    label: str
    values: NDArray[np.floating] | NDArray[np.integer]
    unit: str
    limits: tuple[float, float]
    centre: float | None = None
    categories: tuple[str, ...] = ()

    @property
    def map_name(self) -> str:
        """Which of colour_map's tables the values are drawn with."""
        if self.categories:
            return "categories"
        return "diverging" if self.diverging else "viridis"

    @property
    def diverging(self) -> bool:
        return self.centre is not None

    @property
    def span(self) -> tuple[float, float]:
        """Values at the two ends of the bar: the limits, widened so that `centre` is in the middle."""
        if self.categories:
            return 0.0, CATEGORY_COUNT - 1.0
        low, high = self.limits
        if self.centre is not None:
            reach = max(high - self.centre, self.centre - low)
            low, high = self.centre - reach, self.centre + reach
        return (low, high) if high > low else (low, low + 1.0)

    def fraction(self) -> NDArray[np.float32]:
        """Values as positions along the bar, (node_count,) float32 in [0, 1]; not finite counts as 0."""
        low, high = self.span
        fraction = (np.asarray(self.values, dtype=np.float32) - np.float32(low)) / np.float32(high - low)
        return np.clip(np.nan_to_num(fraction, nan=0.0, posinf=1.0, neginf=0.0), 0.0, 1.0)

    @property
    def title(self) -> str:
        """Label and unit in one line."""
        return f"{self.label} [{self.unit}]" if self.unit else self.label


class SessionView(Protocol):
    """A session as the viewer sees it; a simulation may be filling `history` from another thread.

    model: the tongue and the mouth around it.
    history: what has been simulated so far.
    title: what is being played, for the window's title and for pictures.
    solver_name: e.g. "reduced".
    duration: length of the whole trajectory [s].
    """

    model: TongueModel
    history: StateHistory
    title: str
    solver_name: str
    duration: float

    @property
    def failure(self) -> str | None:
        """The sentence that says why the simulation stopped early; None while all is well."""
        ...

    @property
    def notice(self) -> str | None:
        """A sentence about what went less than well while the simulation goes on; None for nothing."""
        ...

    def field_names(self) -> tuple[str, ...]:
        """Names that `field` knows; the first is usually NO_FIELD."""
        ...

    def field(self, name: str, sample: Sample) -> ScalarField:
        """The named field at `sample`. Not called for NO_FIELD."""
        ...


def simulated_until(session: SessionView) -> float:
    """Time up to which `session.history` can be read [s]; 0 before the first frame."""
    times = session.history.time
    return float(times[-1]) if len(times) else 0.0


def sample_at(session: SessionView, time: float) -> Sample:
    """The history at `time`; before the first frame, the tongue at rest."""
    if session.history.frame_count:
        return session.history.sample(time)
    rest = session.model.sensor_rest_positions
    nodes = session.model.mesh.nodes.astype(np.float32)
    return Sample(time=0.0, nodes=nodes, sensors=rest, sensor_targets=rest, jaw_translation=np.zeros(3))
