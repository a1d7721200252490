"""How deep points of the tongue lie in the rigid mouth, for one tongue or many."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import warp as wp
from numpy.typing import NDArray

from ..kernels.contact import contact_kernels
from ..kernels.precision import precision
from .pose import RigidPose
from .signed_distance import SignedDistanceGrid, by_frame
from .tongue_model import TongueModel
from .units import MM_PER_M


def recorded_launch(
    kernel: wp.Kernel, shape: tuple[int, int], inputs: Sequence[object], outputs: list[wp.array], device: str
) -> wp.Launch | None:
    """A launch over points and tongues whose arguments are packed once; None where there is no point."""
    if 0 in shape:
        return None
    return wp.launch(kernel, shape, list(inputs), outputs, device=device, record_cmd=True)


class JawPoses:
    """The jaw's pose in the head, one for each tongue, on a device: a new one costs no launch.

    rotation: (tongue_count,) of mat33; translation: (tongue_count,) of vec3 [m]; identity at first.
    """

    def __init__(self, tongue_count: int = 1, precision_name: str = "float64", device: str = "cpu") -> None:
        p = precision(precision_name)
        self.count = tongue_count
        identity = np.tile(np.eye(3), (tongue_count, 1, 1))
        self.rotation: wp.array = wp.array(identity, dtype=p.mat33, device=device)
        self.translation = wp.zeros(tongue_count, dtype=p.vec3, device=device)

    def assign(self, poses: RigidPose | Sequence[RigidPose]) -> None:
        """Sets the pose of all tongues, or of each."""
        each = [poses] * self.count if isinstance(poses, RigidPose) else list(poses)
        self.rotation.assign(np.array([pose.rotation for pose in each]))
        self.translation.assign(np.array([pose.translation for pose in each]))

    def copy_from(self, other: "JawPoses") -> None:
        """Overwrites these poses on the device."""
        wp.copy(self.rotation, other.rotation)
        wp.copy(self.translation, other.translation)


class ContactDepth:
    """Depth of points in the rigid bodies of both frames, beyond the depth that each has at rest.

    rest: (point_count, 3) [m], jaw frame. grids: of the rigid parts. The arrays live on `device`:
    displacement: (point_count, 3, tongue_count) [m], jaw frame, read. poses: of the jaw, read.
    depth: (2, point_count, tongue_count) [m], zero without contact, in the jaw's bodies and in the head's, written.
    """

    def __init__(
        self,
        rest: NDArray[np.float64],
        grids: tuple[SignedDistanceGrid, ...],
        tongue_count: int = 1,
        precision_name: str = "float64",
        device: str = "cpu",
        displacement: wp.array | None = None,
    ) -> None:
        self.device = device
        self.shape = (len(rest), tongue_count)
        self._kernels = contact_kernels(precision_name)
        self._scalar = precision(precision_name).scalar
        self.poses = JawPoses(tongue_count, precision_name, device)
        self._rest: wp.array = wp.array(rest, dtype=self._scalar, device=device)
        ordered = by_frame(grids)
        # The sample is in this precision, so that a point at rest is exactly as deep as it may be.
        at_rest = [grid.sample(rest, precision_name, device)[0] for grid in ordered]
        allowed = np.maximum(-np.array(at_rest), 0.0)
        self._allowed: wp.array = wp.array(allowed, dtype=self._scalar, device=device)
        self._grids = [grid.on_device(precision_name, device) for grid in ordered]
        self.displacement = self._zeros(len(rest), 3, tongue_count) if displacement is None else displacement
        self.depth = self._zeros(2, len(rest), tongue_count)
        self.deepest = self._zeros(tongue_count)
        self.contact_count = wp.zeros(tongue_count, dtype=wp.int32, device=device)

    def _zeros(self, *shape: int) -> wp.array:
        return wp.zeros(shape, dtype=self._scalar, device=self.device)

    @property
    def inputs(self) -> list[object]:
        """What every kernel that looks for contacts reads, in the order of its arguments."""
        pose: list[object] = [self.poses.rotation, self.poses.translation]
        return [self._rest, self.displacement, *pose, *self._grids, self._allowed]

    @cached_property
    def _depth_launch(self) -> wp.Launch | None:
        return recorded_launch(self._kernels.depth, self.shape, self.inputs, [self.depth], self.device)

    @cached_property
    def _summary_launch(self) -> wp.Launch | None:
        outputs = [self.deepest, self.contact_count]
        return recorded_launch(self._kernels.summary, self.shape, [self.depth], outputs, self.device)

    def evaluate(self) -> None:
        """Fills `depth` from `displacement` and `poses`."""
        if self._depth_launch is not None:
            self._depth_launch.launch()

    def summarise(self) -> None:
        """Fills `deepest` (tongue_count,) [m] and `contact_count` (tongue_count,) from `depth`."""
        self.deepest.zero_()
        self.contact_count.zero_()
        if self._summary_launch is not None:
            self._summary_launch.launch()


@dataclass(frozen=True)
class Penetration:
    """deepest [mm]: greatest depth of a surface node in a rigid part; contact_count: nodes that touch one."""

    deepest: float
    contact_count: int


class SurfacePenetration:
    """Measures the whole surface of one tongue against the rigid mouth, whatever solver moved it.

    Attached nodes, which bone holds, are left out; depths are beyond those at rest.
    """

    def __init__(self, tongue: TongueModel, grids: tuple[SignedDistanceGrid, ...]) -> None:
        self._node_count = tongue.mesh.node_count
        self._nodes = np.setdiff1d(tongue.mesh.boundary_nodes, tongue.fixed_nodes)
        self._rest = tongue.mesh.nodes[self._nodes]
        self._depth = ContactDepth(self._rest, grids)
        self._displacement = self._depth.displacement.numpy()[:, :, 0]

    def _evaluate(self, nodes: NDArray[np.floating], jaw_pose: RigidPose) -> None:
        np.subtract(nodes[self._nodes], self._rest, out=self._displacement)
        self._depth.poses.assign(jaw_pose)
        self._depth.evaluate()

    def measure(self, nodes: NDArray[np.floating], jaw_pose: RigidPose) -> Penetration:
        """The penetration of node positions (node_count, 3) [m], jaw frame."""
        self._evaluate(nodes, jaw_pose)
        self._depth.summarise()
        return Penetration(
            MM_PER_M * float(self._depth.deepest.numpy()[0]), int(self._depth.contact_count.numpy()[0])
        )

    def depths(self, nodes: NDArray[np.floating], jaw_pose: RigidPose) -> NDArray[np.float64]:
        """Depth of every node [mm], (node_count,); zero inside the tongue and where bone holds it."""
        self._evaluate(nodes, jaw_pose)
        result = np.zeros(self._node_count)
        result[self._nodes] = MM_PER_M * self._depth.depth.numpy()[:, :, 0].max(axis=0, initial=0.0)
        return result
