"""Motion of the jaw taken off the other coils, so that what is left is motion in the jaw frame.

One coil on the lower incisors gives the jaw's translation there, not its rotation; Luo (2017) and Yang
(2013) subtract the same. With the jaw's displacement d(t) = x_LI(t) - x_LI(0), coordinates in the jaw frame,
which coincides with the head frame at frame 0, are x(t) - d(t).
"""

from dataclasses import replace

import numpy as np

from ..model.errors import LingualError
from ..model.trajectory import Trajectory


def remove_jaw_motion(trajectory: Trajectory, jaw_channel: str = "LI") -> Trajectory:
    """The trajectory in the jaw frame, with jaw_translation the jaw's displacement from frame 0.

    A coordinate in which the jaw was not measured counts as still. The jaw's own channel stays and is
    constant. Raises LingualError when the trajectory is in the jaw frame already or has no such channel.
    """
    if trajectory.frame == "jaw":
        raise LingualError(f"{trajectory.source}: jaw motion has been removed already.")
    c = trajectory.channel_index(jaw_channel)
    jaw = trajectory.positions[:, c]
    displacement = np.where(trajectory.measured[c], jaw - jaw[0], 0.0)
    return replace(
        trajectory,
        positions=trajectory.positions - displacement[:, None],
        frame="jaw",
        jaw_translation=displacement,
    )
