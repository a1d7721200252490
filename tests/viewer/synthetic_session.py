"""A small invented tongue in an invented mouth, moving by formula: all that the viewer's tests need."""

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from lingual.model import (
    SENSOR_NAMES,
    EmbeddedSurface,
    RigidSurface,
    SensorLayout,
    StateHistory,
    TetMesh,
    TongueModel,
)
from lingual.model.history import Sample
from lingual.viewer.session_view import NO_FIELD, ScalarField

_CENTRE = np.array([-0.035, 0.0, -0.008])
_RADII = np.array([0.030, 0.020, 0.014])


def ball_mesh(cells: int = 7) -> TetMesh:
    """An ellipsoid of tetrahedra: a cube's grid pulled onto spheres."""
    axis = np.linspace(-1.0, 1.0, cells + 1)
    cube = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3)
    longest = np.abs(cube).max(axis=1, keepdims=True)
    length = np.maximum(np.linalg.norm(cube, axis=1, keepdims=True), 1e-12)
    nodes = _CENTRE + _RADII * cube * longest / length
    n = cells + 1
    i, j, k = (g.ravel() for g in np.meshgrid(*[np.arange(cells)] * 3, indexing="ij"))

    def corner(a: int, b: int, c: int) -> NDArray[np.int64]:
        return ((i + a) * n + j + b) * n + k + c

    # Kuhn's six tetrahedra of a cell, one for each order of the axes.
    paths = [(0, 1, 2), (0, 2, 1), (1, 0, 2), (1, 2, 0), (2, 0, 1), (2, 1, 0)]
    tets = []
    for path in paths:
        at, corners = [0, 0, 0], [corner(0, 0, 0)]
        for axis_index in path:
            at[axis_index] = 1
            corners.append(corner(*at))
        tets.append(np.stack(corners, axis=1))
    tets = np.concatenate(tets)
    x = nodes[tets]
    negative = np.linalg.det(x[:, 1:] - x[:, :1]) < 0.0
    tets[negative] = tets[negative][:, [0, 2, 1, 3]]
    volumes = np.linalg.det(nodes[tets][:, 1:] - nodes[tets][:, :1])
    return TetMesh(nodes, tets[volumes > 1e-14].astype(np.int32))


def box(centre: tuple[float, float, float], size: tuple[float, float, float]) -> tuple[NDArray, NDArray]:
    """A closed box: vertices (8, 3) [m] and outward triangles (12, 3)."""
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return np.array(centre) + 0.5 * signs * np.array(size), np.array(triangles, dtype=np.int32)


def mouth() -> tuple[RigidSurface, ...]:
    """Two teeth and a bar of jaw (closed), a palate (an open sheet)."""
    x, y = np.meshgrid(np.linspace(-0.06, -0.005, 12), np.linspace(-0.022, 0.022, 10), indexing="ij")
    z = 0.016 - 12.0 * y**2
    sheet = np.stack([x, y, z], axis=-1).reshape(-1, 3)
    corner = (np.arange(11)[:, None] * 10 + np.arange(9)).ravel()
    triangles = np.concatenate(
        [np.stack([corner, corner + 10, corner + 11], 1), np.stack([corner, corner + 11, corner + 1], 1)]
    )
    return (
        RigidSurface("palate", "mucosa", "head", sheet, triangles.astype(np.int32)),
        RigidSurface("mandible", "bone", "jaw", *box((-0.03, 0.0, -0.026), (0.05, 0.03, 0.006))),
        RigidSurface("lower_teeth", "tooth", "jaw", *box((-0.001, 0.006, -0.012), (0.005, 0.007, 0.010))),
        RigidSurface("upper_teeth", "tooth", "head", *box((0.001, -0.006, 0.006), (0.005, 0.007, 0.010))),
    )


def synthetic_model() -> TongueModel:
    """The ellipsoid with four coils on top, held at the bottom."""
    mesh = ball_mesh()
    surface = mesh.boundary_nodes
    index = np.zeros(mesh.node_count, dtype=np.int32)
    index[surface] = np.arange(len(surface))
    picks = (np.ones(len(surface), dtype=np.float32), (np.arange(len(surface)), surface))
    skin = EmbeddedSurface(index[mesh.boundary_triangles], sp.csr_array(picks, shape=(len(surface), mesh.node_count)))
    wanted = _CENTRE + _RADII * np.array([[0.8, 0, 0.6], [0.3, 0, 0.95], [-0.2, 0, 0.98], [-0.7, 0, 0.7]])
    nearest = [surface[np.argmin(np.linalg.norm(mesh.nodes[surface] - p, axis=1))] for p in wanted]
    weights = sp.csr_array((np.ones(4), (np.arange(4), nearest)), shape=(4, mesh.node_count))
    fixed = np.flatnonzero(mesh.nodes[:, 2] < np.quantile(mesh.nodes[:, 2], 0.1))
    return TongueModel("ellipsoid", mesh, fixed, SensorLayout(SENSOR_NAMES, weights), skin, mouth())


class SyntheticSession:
    """Plays SessionView: a wave runs through the tongue while the jaw opens and closes."""

    title = "synthetic"
    solver_name = "formula"

    def __init__(self, duration: float = 1.0, simulated: float | None = None) -> None:
        self.model = synthetic_model()
        self.duration = duration
        self.failure: str | None = None
        self.notice: str | None = None
        self.history = StateHistory(self.model.mesh.node_count, self.model.sensors.count)
        self.simulate_until(duration if simulated is None else simulated)

    def simulate_until(self, time: float) -> None:
        """Appends the frames up to `time` [s]."""
        while self.history.frame_count <= round(100 * time):
            now = self.history.frame_count / 100.0
            rest = self.model.mesh.nodes
            height = np.clip((rest[:, 2] + 0.022) / 0.028, 0.0, 1.0)
            nodes = rest.copy()
            nodes[:, 2] += 0.006 * height * np.sin(2.0 * np.pi * (now + 10.0 * rest[:, 0]))
            sensors = self.model.sensors.positions(nodes)
            jaw = np.array([0.0, 0.0, -0.003 * np.sin(np.pi * now)])
            targets = sensors + np.array([0.0, 0.0, 0.003])
            self.history.append(now, nodes, sensors, targets, jaw, step_ms=1.5)

    def field_names(self) -> tuple[str, ...]:
        return (NO_FIELD, "displacement", "height change")

    def field(self, name: str, sample: Sample) -> ScalarField:
        moved = 1e3 * (sample.nodes - self.model.mesh.nodes)
        if name == "displacement":
            return ScalarField(name, np.linalg.norm(moved, axis=1), "mm", (0.0, 6.0))
        return ScalarField(name, moved[:, 2], "mm", (-6.0, 6.0), centre=0.0)
