"""The linear-tetrahedron discretisation of a tongue: elastic energy, forces and stiffness on the mesh.

Wraps the Warp kernels with the arrays of one mesh on one device, so that precomputation, the
full-space solver, diagnostics and tests evaluate the same terms.
"""

from functools import cached_property

import numpy as np
import scipy.sparse as sp
import warp as wp
from numpy.typing import NDArray

from ..kernels.elasticity import elasticity_kernels
from ..kernels.full_space import full_space_kernels
from ..kernels.precision import precision
from .material import Material
from .tet_mesh import TetMesh


class ElementForces:
    """Evaluates the material on an array of weighted elements given their displacement gradients.

    weights: integration weight of each element [m^3], (element_count,). All arrays live on `device`
    in `precision_name` ("float32" or "float64"). `stress` and `tangent` are overwritten by each call.
    """

    def __init__(
        self, material: Material, weights: NDArray[np.float64], precision_name: str = "float64", device: str = "cpu"
    ) -> None:
        self.count = len(weights)
        self.device = device
        self.precision = precision(precision_name)
        self._kernels = elasticity_kernels(material.model, precision_name)
        self._material = self.precision.parameters(*material.elastic_parameters)
        self._viscosity = self.precision.parameters(*material.viscous_parameters)
        self._damping = material.damping_stiffness
        self.weights: wp.array = wp.array(weights, dtype=self.precision.scalar, device=device)
        self.gradient = self._elements(self.precision.mat33)
        self.gradient_start = self._elements(self.precision.mat33)
        self.stress = self._elements(self.precision.mat33)

    def _elements(self, dtype: type) -> wp.array:
        return wp.zeros(self.count, dtype=dtype, device=self.device)

    @cached_property
    def tangent(self) -> wp.array:
        """Weighted tangent, (element_count, 3, 3) of mat33: [e, i, m][j, n] = dP_ij / dF_mn."""
        return wp.zeros((self.count, 3, 3), dtype=self.precision.mat33, device=self.device)

    @cached_property
    def _fields(self) -> tuple[wp.array, wp.array]:
        return self._elements(self.precision.scalar), self._elements(self.precision.scalar)

    def begin_step(self) -> None:
        """Makes the current gradient the start of the step, to which the damping refers."""
        wp.copy(self.gradient_start, self.gradient)

    def _recorded(self, kernel: wp.Kernel, inputs: list[object], output: wp.array) -> wp.Launch:
        """A launch over all elements whose arguments are packed once: packing costs more than the kernel."""
        return wp.launch(kernel, self.count, inputs, [output], device=self.device, record_cmd=True)

    @property
    def _material_inputs(self) -> list[object]:
        undamped = self.precision.scalar(0.0)
        return [self.gradient, self.gradient_start, self.weights, self._material, self._viscosity, undamped]

    @cached_property
    def _stress_launch(self) -> wp.Launch:
        return self._recorded(self._kernels.stress, self._material_inputs, self.stress)

    @cached_property
    def _tangent_launch(self) -> wp.Launch:
        return self._recorded(self._kernels.tangent, self._material_inputs, self.tangent)

    @cached_property
    def _definite_tangent_launch(self) -> wp.Launch:
        return self._recorded(self._kernels.definite_tangent, self._material_inputs, self.tangent)

    @cached_property
    def _product_launch(self) -> wp.Launch:
        inputs: list[object] = [self.tangent, self.direction]
        return self._recorded(self._kernels.tangent_product, inputs, self.direction_stress)

    def _launch_damped(self, launch: wp.Launch, step: float | None) -> None:
        launch.set_param_by_name("damping_over_step", self.precision.scalar(self._damping / step if step else 0.0))
        launch.launch()

    def evaluate_stress(self, step: float | None = None) -> None:
        """Fills `stress` from `gradient`; with the damping of a step of `step` seconds when given."""
        self._launch_damped(self._stress_launch, step)

    def evaluate_tangent(self, step: float | None = None, definite: bool = False) -> None:
        """Fills `tangent` from `gradient`; with the damping of a step of `step` seconds when given.

        definite: with the negative eigenvalues of every element's elastic tangent set to zero.
        """
        self._launch_damped(self._definite_tangent_launch if definite else self._tangent_launch, step)

    @cached_property
    def direction(self) -> wp.array:
        """Displacement gradients of a direction, (element_count,) of mat33, for `apply_tangent`."""
        return self._elements(self.precision.mat33)

    @cached_property
    def direction_stress(self) -> wp.array:
        """What `apply_tangent` fills: the weighted change of stress along `direction`."""
        return self._elements(self.precision.mat33)

    def apply_tangent(self) -> None:
        """Fills `direction_stress` from `direction` and the `tangent` evaluated last."""
        self._product_launch.launch()

    def energy_density(self) -> tuple[NDArray[np.floating], NDArray[np.floating]]:
        """Strain energy density [Pa] and det F of each element, two arrays (element_count,)."""
        density, det_f = self._fields
        inputs = [self.gradient, self._material]
        wp.launch(self._kernels.energy, self.count, inputs, [density, det_f], device=self.device)
        return density.numpy(), det_f.numpy()


class Discretisation:
    """Elastic terms on all elements of a mesh, and their sum at the nodes.

    mesh, material: what is discretised. free_nodes: sorted indices of the nodes that move; rows and
    columns of the stiffness are theirs (3 per node), all nodes by default.
    """

    def __init__(
        self,
        mesh: TetMesh,
        material: Material,
        free_nodes: NDArray[np.int64] | None = None,
        precision_name: str = "float64",
        device: str = "cpu",
    ) -> None:
        self.mesh = mesh
        self.free_nodes = np.arange(mesh.node_count) if free_nodes is None else free_nodes
        self.elements = ElementForces(material, mesh.volumes, precision_name, device)
        p = self.elements.precision
        self._kernels = full_space_kernels(precision_name)
        self._tets: wp.array = wp.array(mesh.tets, dtype=wp.int32, device=device)
        self._shape_gradients: wp.array = wp.array(mesh.shape_gradients, dtype=p.vec3, device=device)
        self._displacement = wp.zeros(mesh.node_count, dtype=p.vec3, device=device)
        self._force = wp.zeros(mesh.node_count, dtype=p.vec3, device=device)
        self.device = device

    def set_displacement(self, displacement: NDArray[np.floating]) -> None:
        """Evaluates the displacement gradients of displacement (node_count, 3) [m]."""
        self._displacement.assign(displacement)
        wp.launch(
            self._kernels.displacement_gradient,
            self.mesh.tet_count,
            [self._displacement, self._tets, self._shape_gradients],
            [self.elements.gradient],
            device=self.device,
        )

    def internal_force(self, step: float | None = None) -> NDArray[np.floating]:
        """Gradient of the energy with respect to the nodes [N], (node_count, 3), at the set displacement."""
        self.elements.evaluate_stress(step)
        wp.launch(
            self._kernels.gather_force,
            self.mesh.node_count,
            [self.elements.stress, self._shape_gradients, *self._corners],
            [self._force],
            device=self.device,
        )
        return self._force.numpy()

    @cached_property
    def pattern(self) -> "BlockPattern":
        """Where the stiffness has blocks."""
        return BlockPattern(self.mesh, self.free_nodes)

    @cached_property
    def _corners(self) -> list[wp.array]:
        return self._lists(self.mesh.tets.ravel(), self.mesh.node_count)

    @cached_property
    def _pairs(self) -> list[wp.array]:
        return self._lists(self.pattern.block_of_pair.ravel(), len(self.pattern.columns))

    def _lists(self, owner: NDArray[np.integer], count: int) -> list[wp.array]:
        """For each of `count` owners where its list starts, and the lists of indices into `owner`; -1 owns nothing."""
        members = np.argsort(owner, kind="stable")[np.sum(owner < 0) :]
        starts = np.concatenate([[0], np.cumsum(np.bincount(owner[owner >= 0], minlength=count))])
        return [wp.array(a.astype(np.int32), dtype=wp.int32, device=self.device) for a in (starts, members)]

    @cached_property
    def blocks(self) -> wp.array:
        """3x3 blocks of the stiffness evaluated last, in the order of `pattern`."""
        return wp.zeros(len(self.pattern.columns), dtype=self.elements.precision.mat33, device=self.device)

    def evaluate_stiffness(self, step: float | None = None, definite: bool = False) -> None:
        """Fills `blocks` with the Hessian of the energy between the free nodes [N/m], at the set displacement.

        definite: of each element's nearest positive-semidefinite one.
        """
        self.elements.evaluate_tangent(step, definite)
        wp.launch(
            self._kernels.gather_stiffness,
            len(self.blocks),
            [self.elements.tangent, self._shape_gradients, *self._pairs],
            [self.blocks],
            device=self.device,
        )

    def stiffness(self, step: float | None = None, definite: bool = False) -> sp.bsr_array:
        """`evaluate_stiffness` as a matrix (3 free, 3 free).

        The values are a view that the next call overwrites.
        """
        self.evaluate_stiffness(step, definite)
        size = 3 * len(self.free_nodes)
        pattern = (self.blocks.numpy(), self.pattern.columns, self.pattern.row_starts)
        return sp.bsr_array(pattern, shape=(size, size))


class BlockPattern:
    """Sparsity of node pairs that share an element, in block compressed rows of the free nodes.

    columns (block_count,), row_starts (free + 1,): the pattern. block_of_pair (tet_count, 4, 4): the
    block of each node pair of each element, -1 where a node is fixed.
    """

    def __init__(self, mesh: TetMesh, free_nodes: NDArray[np.int64]) -> None:
        free_index = np.full(mesh.node_count, -1, dtype=np.int64)
        free_index[free_nodes] = np.arange(len(free_nodes))
        corner = free_index[mesh.tets]
        rows = np.repeat(corner, 4, axis=1).reshape(-1)
        columns = np.tile(corner, (1, 4)).reshape(-1)
        kept = (rows >= 0) & (columns >= 0)
        keys, block = np.unique(rows[kept] * len(free_nodes) + columns[kept], return_inverse=True)
        pairs = np.full(rows.shape, -1, dtype=np.int32)
        pairs[kept] = block
        self.block_of_pair = pairs.reshape(mesh.tet_count, 4, 4)
        self.columns = (keys % len(free_nodes)).astype(np.int32)
        counts = np.bincount(keys // len(free_nodes), minlength=len(free_nodes))
        self.row_starts = np.concatenate([[0], np.cumsum(counts)]).astype(np.int32)
