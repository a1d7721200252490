"""Drives a solver along a trajectory and keeps every frame, whatever happens on the way."""

import logging
import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from ..model import Control, RigidPose, State, StateHistory, Trajectory
from ..model.contact_depth import Penetration, SurfacePenetration
from ..model.discretisation import Discretisation
from ..model.signed_distance import SignedDistanceGrid
from ..solver.protocol import Solver

SMALLEST_SUBSTEP = 1.0 / 8.0
"""Share of a time step below which a step that does not converge is not halved again."""

FARTHEST_DISPLACEMENT = 3.0
"""Displacement of a node, in diagonals of the tongue, that no motion has: the solver has diverged."""

log = logging.getLogger(__name__)


@dataclass(frozen=True)
class FrameDiagnostics:
    """What is measured in every frame. Times in ms, lengths in mm, energy in J."""

    step_ms: float
    newton_iterations: float
    converged: float
    substeps: float
    volume_ratio: float
    det_f_min: float
    inverted_tet_count: float
    strain_energy: float
    sensor_error_mm: float
    penetration_mm: float
    contact_count: float


@dataclass
class Simulation:
    """One solver, one trajectory fitted to its tongue's sensors (jaw frame), one history.

    grids: distance to the rigid mouth, in which penetration is measured; none without it.
    `run` may be called in a thread of its own; readers use `history` meanwhile.
    """

    solver: Solver
    trajectory: Trajectory
    grids: tuple[SignedDistanceGrid, ...] = ()
    history: StateHistory = field(init=False)
    unconverged_frames: list[int] = field(default_factory=list)
    newton_iterations: int = 0

    def __post_init__(self) -> None:
        tongue = self.solver.tongue
        frames = self.trajectory.frame_count
        self.history = StateHistory(tongue.mesh.node_count, tongue.sensors.count, min(max(frames, 1), 1024))
        self._discretisation = Discretisation(tongue.mesh, tongue.material)
        self._surface = SurfacePenetration(tongue, self.grids) if self.grids else None
        self._states = [self.solver.new_state() for _ in range(3)]
        self._states[0].time = float(self.trajectory.time[0]) - self._frame_step(0)
        self._control = Control(tongue.sensor_rest_positions.copy(), self.trajectory.measured)

    def _frame_step(self, frame: int) -> float:
        """Time from the frame before to this one; the first frame is reached from rest in one such step."""
        times = self.trajectory.time
        if len(times) == 1:
            return 0.01
        frame = max(frame, 1)
        return float(times[frame] - times[frame - 1])

    def run(
        self,
        on_frame: Callable[[int], None] = lambda frame: None,
        should_stop: Callable[[], bool] = lambda: False,
    ) -> None:
        """Simulates the frames that the history lacks; returns early when `should_stop` says so."""
        with threadpool_limits(limits=1, user_api="blas"):  # two pools fighting cost more than they give
            while self.history.frame_count < self.trajectory.frame_count and not should_stop():
                frame = self.history.frame_count
                self._simulate_frame(frame)
                on_frame(frame)

    def _simulate_frame(self, frame: int) -> None:
        started = time.perf_counter()
        substeps, converged = self._advance(frame)
        step_ms = 1e3 * (time.perf_counter() - started)
        if not converged:
            if not self.unconverged_frames:
                when = self.trajectory.time[frame]
                log.warning("Frame %d (%.2f s) did not converge even in %d smaller steps.", frame, when, substeps)
            self.unconverged_frames.append(frame)
        self._record(frame, step_ms, substeps, converged)

    def _advance(self, frame: int) -> tuple[int, bool]:
        """Brings state 0 to the frame; halves the step while it does not converge. Substeps, success."""
        previous = self._control.sensor_targets.copy()
        target = self.trajectory.positions[frame]
        self._control.jaw_pose = RigidPose(translation=self.trajectory.jaw_translation[frame])
        whole = self._frame_step(frame)
        substeps, self.newton_iterations = 1, 0
        while True:
            finished, converged = self._take_substeps(previous, target, whole, substeps)
            if converged or 1.0 / substeps <= SMALLEST_SUBSTEP:
                break
            substeps *= 2
        if self._usable(finished.position.numpy()):
            self._states[0].copy_from(finished)
        else:
            self._states[0].velocity.zero_()
            self._states[0].coordinate_velocity.zero_()
        self._states[0].time = float(self.trajectory.time[frame])
        self._control.sensor_targets[:] = target
        return substeps, converged

    def _usable(self, position: NDArray) -> bool:
        """Whether a step ended somewhere that the next may start from: a diverged one may be finite and far away."""
        rest = self.solver.tongue.mesh.nodes
        farthest = FARTHEST_DISPLACEMENT * np.linalg.norm(np.ptp(rest, axis=0))
        return bool(np.isfinite(position).all() and np.abs(position - rest).max() < farthest)

    def _take_substeps(
        self, previous: NDArray[np.float64], target: NDArray[np.float64], whole: float, substeps: int
    ) -> tuple[State, bool]:
        start, *others = self._states
        converged = True
        for n in range(substeps):
            end = others[n % 2]
            share = (n + 1) / substeps
            self._control.sensor_targets[:] = (1.0 - share) * previous + share * target
            self.solver.step(start, end, self._control, whole / substeps)
            converged = converged and self.solver.report.converged
            self.newton_iterations += self.solver.report.iterations
            start = end
        return start, converged

    def _record(self, frame: int, step_ms: float, substeps: int, converged: bool) -> None:
        tongue = self.solver.tongue
        nodes = self._states[0].position.numpy()
        sensors = tongue.sensors.positions(nodes)
        target = self.trajectory.positions[frame]
        diagnostics = self._diagnose(nodes, sensors - target, step_ms, substeps, converged)
        self.history.append(
            float(self.trajectory.time[frame]),
            nodes,
            sensors,
            target,
            self.trajectory.jaw_translation[frame],
            **vars(diagnostics),
        )

    def _diagnose(
        self, nodes: NDArray, sensor_gap: NDArray, step_ms: float, substeps: int, converged: bool
    ) -> FrameDiagnostics:
        mesh = self.solver.tongue.mesh
        self._discretisation.set_displacement(nodes - mesh.nodes)
        density, det_f = self._discretisation.elements.energy_density()
        gaps = np.abs(sensor_gap[self.trajectory.measured])
        touching = self._surface.measure(nodes, self._control.jaw_pose) if self._surface else Penetration(0.0, 0)
        return FrameDiagnostics(
            step_ms=step_ms,
            newton_iterations=self.newton_iterations,
            converged=float(converged),
            substeps=substeps,
            volume_ratio=float(det_f @ mesh.volumes) / mesh.volume,
            det_f_min=float(det_f.min()),
            inverted_tet_count=float(np.sum(det_f <= 0.0)),
            strain_energy=float(density @ mesh.volumes),
            sensor_error_mm=1e3 * float(gaps.max(initial=0.0)),
            penetration_mm=touching.deepest,
            contact_count=touching.contact_count,
        )
