"""A short movement of the small tongue, a solver that fails on demand, and the command line in process."""

import sys
import warnings

import numpy as np
import pytest

from lingual.app.command_line import main
from lingual.model import Trajectory
from lingual.solver.full_space import SolverFullSpace
from lingual.solver.protocol import StepReport


@pytest.fixture(scope="session")
def trajectory(small_tongue) -> Trajectory:
    """Eight frames at 100 Hz: tip up and back by 5 mm, dorsum up by 3 mm, y not measured, the jaw opening."""
    share = np.sin(np.linspace(0.0, np.pi, 8))
    moved = np.zeros((8, 4, 3))
    moved[:, 0] = share[:, None] * [-0.002, 0.0, 0.005]
    moved[:, 2, 2] = 0.003 * share
    return Trajectory(
        time=0.01 * np.arange(8),
        channels=small_tongue.sensors.names,
        positions=small_tongue.sensor_rest_positions + moved,
        measured=np.tile([True, False, True], (4, 1)),
        frame="jaw",
        jaw_translation=share[:, None] * [0.0, 0.0, -0.004],
        source="movement",
    )


class MovingSolver:
    """Implements the solver protocol: carries the whole tongue with the first sensor's target.

    largest_step: function time [s] -> the largest step that converges there. spoils: what a step that
    does not converge leaves in the positions: "nearest" (the target all the same) or "nan".
    """

    name = "moving"
    dof_count = 3
    volume_mode = "none"
    contact_point_count = 0

    def __init__(self, tongue, largest_step, spoils: str = "nearest") -> None:
        self.tongue = tongue
        self.report = StepReport()
        self.steps = []
        self._largest_step, self._spoils = largest_step, spoils

    def new_state(self):
        return SolverFullSpace(self.tongue).new_state()

    def step(self, state_in, state_out, control, dt):
        converged = dt <= 1.000001 * self._largest_step(state_in.time + dt)
        moved = control.sensor_targets[0] - self.tongue.sensor_rest_positions[0]
        state_out.position.numpy()[:] = self.tongue.mesh.nodes + moved
        if not converged and self._spoils == "nan":
            state_out.position.numpy()[:] = np.nan
        state_out.time = state_in.time + dt
        self.report.iterations, self.report.converged = (3, True) if converged else (15, False)
        self.steps.append((dt, control.sensor_targets[0].copy()))


@pytest.fixture(scope="session")
def moving_solver(small_tongue):
    """Function (largest_step, spoils) -> MovingSolver of the small tongue."""
    return lambda largest_step=lambda time: np.inf, spoils="nearest": MovingSolver(small_tongue, largest_step, spoils)


@pytest.fixture
def lingual(monkeypatch, capsys, tmp_path):
    """Function (*arguments) -> (exit code, stdout, stderr) of the `lingual` command, run in this process."""
    monkeypatch.setattr(warnings, "showwarning", warnings.showwarning)  # restored afterwards
    monkeypatch.setenv("LINGUAL_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("DISPLAY", raising=False)
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    monkeypatch.chdir(tmp_path)

    def run(*arguments) -> tuple[int, str, str]:
        monkeypatch.setattr(sys, "argv", ["lingual", *map(str, arguments)])
        code = 0
        with warnings.catch_warnings():
            try:
                main()
            except SystemExit as end:
                code = end.code or 0
        out, err = capsys.readouterr()
        return code, out, err

    return run


@pytest.fixture
def wedge_file(wedge, write_tetgen):
    """The wedge as a user's mesh file, in mm."""
    return write_tetgen(*wedge)
