"""What is measured of one tongue. Every function returns milliseconds, or tongue-frames a second for a batch."""

import numpy as np

from ...model import Control, RigidPose
from ...model.modal_model import ModalModel
from ...precompute.modes import build_modal_model
from ...solver.full_space import SolverFullSpace
from ...solver.modal_warping import SolverModalWarping
from ...solver.protocol import Solver
from ...solver.tongue_batch import TongueBatch
from ...solver.volume_full_space import VolumeFullSpace
from ...solver.volume_subspace import SubspaceVolume
from .subject import Subject
from .timing import median_ms, median_over_frames_ms

TOLERANCE = 1e-4
"""Relative residual to which the reduced and the full-space step both converge: what other programs' steps do."""
STEP = 0.01
MODE_COUNT = 100
WARM_UP_FRAMES = 10
HOST_BATCH, DEVICE_BATCH = 32, 1024
BATCH_FRAMES = 12
CAPTURED_EVALUATIONS = 6
"""Evaluations of a captured step: two fewer than the solver's default. In fast movements a few frames in a hundred end
above TOLERANCE with them (docs/performance.md)."""


def reduced_frame_ms(subject: Subject, device: str, frames: int) -> float:
    """One tongue's frame: sensors, contact, volume and the position of every node, in float32."""
    batch = _batch(subject, 1, device)
    poses = [RigidPose(translation=t) for t in subject.trajectory.jaw_translation]

    def advance(frame: int) -> None:
        batch.set_jaw_poses(poses[frame])
        batch.set_targets(subject.targets[frame])
        batch.step()

    return median_over_frames_ms(advance, min(frames, len(poses)), WARM_UP_FRAMES, device)


def batch_frames_per_second(subject: Subject, device: str) -> float:
    """Tongue-frames a second of many tongues that follow the demonstration with different amplitudes."""
    count = HOST_BATCH if device == "cpu" else DEVICE_BATCH
    batch = _batch(subject, count, device)
    amplitudes = np.linspace(0.4, 1.1, count)

    def advance(frame: int) -> None:
        batch.set_targets(subject.targets[frame][:, None] * amplitudes)
        batch.step()

    ms = median_over_frames_ms(advance, WARM_UP_FRAMES + BATCH_FRAMES, WARM_UP_FRAMES, device)
    return 1e3 * count / ms


def _batch(subject: Subject, count: int, device: str) -> TongueBatch:
    return TongueBatch(
        subject.model,
        subject.trajectory.measured,
        STEP,
        count,
        "float32",
        device,
        TOLERANCE,
        captured_evaluations=CAPTURED_EVALUATIONS,
        contact=subject.scene,
        pressure=subject.pressure,
    )


def full_step_ms(subject: Subject, device: str, frames: int) -> float:
    """One converged full-space step along the demonstration, without contact and volume correction."""
    return _solver_ms(SolverFullSpace(subject.tongue, TOLERANCE, device=device), subject, frames, 3, device)


def modal_frame_ms(subject: Subject, frames: int) -> float:
    """One step of modal warping with sensors and the position of every node."""
    model: ModalModel = build_modal_model(subject.tongue, MODE_COUNT, subject.progress)
    return _solver_ms(SolverModalWarping(model, "float32"), subject, frames, WARM_UP_FRAMES, "cpu")


def _solver_ms(solver: Solver, subject: Subject, frames: int, warm_up: int, device: str) -> float:
    trajectory = subject.trajectory
    states = [solver.new_state(), solver.new_state()]
    control = Control(subject.tongue.sensor_rest_positions.copy(), trajectory.measured)

    def advance(frame: int) -> None:
        control.sensor_targets[:] = trajectory.positions[frame]
        solver.step(states[frame % 2], states[(frame + 1) % 2], control, STEP)

    return median_over_frames_ms(advance, min(frames, trajectory.frame_count), warm_up, device)


def volume_subspace_ms(subject: Subject, device: str, repetitions: int) -> float:
    """One correction of coordinates and their rate, of a tongue moved by the demonstration."""
    batch = _moved(subject, device)
    volume = SubspaceVolume(
        subject.model, subject.pressure, subject.trajectory.measured, 1, "float32", device
    )
    stages = volume.bind_position(batch.coordinates) + volume.bind_velocity(batch.velocity, batch.coordinates)

    def correct() -> None:
        for stage in stages:
            stage()

    return median_ms(correct, repetitions, device=device)


def volume_full_ms(subject: Subject, repetitions: int) -> float:
    """One full-space correction of positions and velocities, from the same uncorrected state every time."""
    trajectory = subject.trajectory
    solver = SolverModalWarping(build_modal_model(subject.tongue, MODE_COUNT, subject.progress))
    start, moved, work = solver.new_state(), solver.new_state(), solver.new_state()
    control = Control(trajectory.positions[_farthest(subject)], trajectory.measured)
    solver.step(start, moved, control, STEP)
    correction = VolumeFullSpace(subject.tongue, trajectory.measured)

    def correct() -> None:
        work.copy_from(moved)
        correction.correct(work)

    return median_ms(correct, repetitions, warm_up=1)


def _moved(subject: Subject, device: str) -> TongueBatch:
    """One tongue in the demonstration's most displaced frame, uncorrected."""
    batch = TongueBatch(
        subject.model, subject.trajectory.measured, STEP, 1, "float32", device, TOLERANCE
    )
    for share in np.linspace(0.1, 1.0, 10):
        batch.set_targets(share * subject.targets[_farthest(subject)])
        batch.step()
    return batch


def _farthest(subject: Subject) -> int:
    return int((subject.targets**2).sum(axis=1).argmax())
