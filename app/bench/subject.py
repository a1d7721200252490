"""The tongues that are measured: three sizes, each with everything that its solvers need."""

from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...model import ReducedModel, TongueModel, Trajectory
from ...model.contact_scene import ContactScene
from ...model.volume_pressure import PressureSubspace
from ...precompute.meshes.library import load_tongue
from ...precompute.progress import Progress
from ..solver_options import SolverOptions
from ..wiring import contact_scene, fitted_trajectory, pressure_subspace, reduced_model

LUO_TONGUE = Path("../shared/data/luo_tongue")
"""Where the mesh of Luo (2017) is looked for when none is named."""

SIZES = ("small", "luo", "paper")
"""About 1,800 nodes; 5,452 nodes, Luo's mesh, or our own head of 5,529; about 11,000 nodes as in the paper."""


def mesh_of(size: str, luo: str | None) -> str | None:
    """Name or path of the mesh of a size, as `load_tongue` takes it."""
    own = {"small": "head-small", "luo": None, "paper": "head-large"}[size]
    if size == "luo" and (luo is not None or LUO_TONGUE.is_dir()):
        return luo or str(LUO_TONGUE)
    return own


@dataclass(frozen=True, eq=False)
class Subject:
    """One tongue and the built-in demonstration as its motion. progress: told of what is prepared."""

    tongue: TongueModel
    progress: Progress

    @classmethod
    def load(cls, mesh: str | None, progress: Progress) -> "Subject":
        """The tongue of a name or path. Raises LingualError for what cannot be used."""
        return cls(load_tongue(mesh, progress), progress)

    @cached_property
    def trajectory(self) -> Trajectory:
        """From the first frame that moves: a tongue at rest costs no iteration and would flatter every solver."""
        whole = fitted_trajectory(None, self.tongue)
        moved = (whole.positions != self.tongue.sensor_rest_positions)[:, whole.measured].any(axis=1)
        first = int(moved.argmax())
        return replace(
            whole,
            time=whole.time[first:],
            positions=whole.positions[first:],
            jaw_translation=whole.jaw_translation[first:],
        )

    @cached_property
    def targets(self) -> NDArray[np.float64]:
        """Displacement of the imposed sensor coordinates [m], (frame_count, constraint_count)."""
        moved = self.trajectory.positions - self.tongue.sensor_rest_positions
        return moved[:, self.trajectory.measured]

    @cached_property
    def model(self) -> ReducedModel:
        return reduced_model(self.tongue, SolverOptions(), self.progress)

    @cached_property
    def pressure(self) -> PressureSubspace:
        return pressure_subspace(self.model, SolverOptions(), self.progress)

    @cached_property
    def scene(self) -> ContactScene | None:
        return contact_scene(self.model, SolverOptions(), self.progress)
