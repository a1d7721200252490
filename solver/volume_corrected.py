"""Any solver with the full-space volume correction after each of its steps."""

import numpy as np

from ..model import Control, ReducedModel, State
from .protocol import Solver
from .volume_full_space import VolumeFullSpace


class SolverVolumeCorrected:
    """Steps as `solver` does, then corrects volume in full space (Luo 2017, Eq. 16); sensors stay where they are."""

    volume_mode = "full"

    def __init__(self, solver: Solver) -> None:
        self._solver = solver
        self.name, self.tongue, self.report = solver.name, solver.tongue, solver.report
        self._corrections: dict[bytes, VolumeFullSpace] = {}

    @property
    def dof_count(self) -> int:
        return self._solver.dof_count

    @property
    def contact_point_count(self) -> int:
        return self._solver.contact_point_count

    def new_state(self) -> State:
        return self._solver.new_state()

    def step(self, state_in: State, state_out: State, control: Control, dt: float) -> None:
        self._solver.step(state_in, state_out, control, dt)
        if not np.isfinite(state_out.position.numpy()).all():
            return
        key = np.packbits(control.sensor_constrained).tobytes()
        if key not in self._corrections:
            model = getattr(self._solver, "model", None)
            basis = model.basis if isinstance(model, ReducedModel) else None  # modes are not corrected, nodes are
            self._corrections[key] = VolumeFullSpace(self.tongue, control.sensor_constrained, basis)
        self._corrections[key].correct(state_out)
