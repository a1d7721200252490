"""From a speaker's coils to those of a mesh: displacements are carried over, positions are not.

target(t) = sensor at rest on the mesh + x(t) - x_reference, so that the mesh is at rest in the reference and
every sensor moves as its coil did. This needs no registration between speaker and mesh, only their axes.
"""

import numpy as np

from ..model.errors import LingualError
from ..model.tongue_model import TongueModel
from ..model.trajectory import Trajectory


def fit_to_sensors(trajectory: Trajectory, model: TongueModel, reference_frames: int = 1) -> Trajectory:
    """Targets for exactly the model's sensors, in their order, jaw frame [m].

    trajectory: in the jaw frame. reference_frames: the mean of so many first frames is the rest; 1 is
    frame 0, the one that fits the mesh in Luo's recordings. A coordinate that was not measured keeps its
    rest value (a number, so that the targets can be drawn) and stays unmeasured.

    Raises LingualError, naming them, for sensors without a channel; for a trajectory in the head frame;
    and for a number of reference frames outside 1 to frame_count.
    """
    source, names = trajectory.source, model.sensors.names
    seen = {n for n, row in zip(trajectory.channels, trajectory.measured, strict=True) if row.any()}
    missing = [name for name in names if name not in seen]
    if missing:
        plural = "s" if len(missing) > 1 else ""
        raise LingualError(
            f"{source} has no measured channel for the sensor{plural} {', '.join(missing)} "
            f"of '{model.name}'; it has {', '.join(trajectory.channels)}."
        )
    if trajectory.frame != "jaw":
        raise LingualError(f"{source} is in the head frame; remove the jaw's motion before fitting it.")
    if not 1 <= reference_frames <= trajectory.frame_count:
        raise LingualError(
            f"{source}: the rest cannot be the mean of {reference_frames} frames; "
            f"choose 1 to {trajectory.frame_count}."
        )
    recorded = trajectory.select(names)
    moved = recorded.positions - recorded.positions[:reference_frames].mean(axis=0)
    targets = model.sensor_rest_positions + np.where(recorded.measured, moved, 0.0)
    return Trajectory(
        time=recorded.time,
        channels=names,
        positions=targets,
        measured=recorded.measured,
        frame="jaw",
        jaw_translation=recorded.jaw_translation,
        source=source,
    )
