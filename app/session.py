"""A session: one tongue, one solver, one trajectory, simulated in the background while it is shown."""

import logging
import threading
from collections.abc import Callable

from ..model import LingualError, ReducedModel
from ..model.history import Sample
from ..viewer.session_view import ScalarField
from .fields import FieldSource
from .simulation import Simulation

log = logging.getLogger(__name__)


class Session:
    """Implements the viewer's SessionView over a Simulation.

    title: what is played. reduced: gives the domain-weight fields when there is one.
    """

    def __init__(self, simulation: Simulation, title: str, reduced: ReducedModel | None = None) -> None:
        self.simulation = simulation
        self.title = title
        self.model = simulation.solver.tongue
        self.history = simulation.history
        self.solver_name = simulation.solver.name
        self.duration = float(simulation.trajectory.time[-1])
        self._fields = FieldSource(simulation.solver.tongue, reduced)
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None
        self.failure: str | None = None

    @property
    def notice(self) -> str | None:
        if count := len(self.simulation.unconverged_frames):
            return f"{count} frame{'s' if count > 1 else ''} did not converge; the nearest state is shown there."
        return None

    def field_names(self) -> tuple[str, ...]:
        return self._fields.names()

    def field(self, name: str, sample: Sample) -> ScalarField:
        return self._fields.field(name, sample)

    def start(self) -> None:
        """Simulates in a background thread until the trajectory or the session ends."""
        self._thread = threading.Thread(target=self._work, name="simulation", daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Ends the background thread; what has been simulated stays."""
        self._stop.set()
        if self._thread:
            self._thread.join()
            self._thread = None

    def simulate(self, on_frame: Callable[[int], None] = lambda frame: None) -> None:
        """Simulates the whole trajectory in the calling thread."""
        self.simulation.run(on_frame, self._stop.is_set)

    def _work(self) -> None:
        try:
            self.simulation.run(should_stop=self._stop.is_set)
        except LingualError as error:
            self.failure = str(error)
        except Exception as error:
            self.failure = f"The simulation stopped at frame {self.history.frame_count}: {error}"
            log.exception("simulation thread")
