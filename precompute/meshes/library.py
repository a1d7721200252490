"""A tongue by name or path: the heads of our own, published meshes, and whatever mesh a user has.

Everything is in metres and the head frame afterwards. What the files do not say comes from
known_meshes.toml or a NAME.lingual.toml beside the mesh; what those do not say is assumed, with a
MeshWarning that says what was assumed.
"""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...model.errors import LingualError
from ...model.sensors import SensorLayout
from ...model.surface import RigidSurface
from ...model.tet_mesh import TetMesh
from ...model.tongue_model import TongueModel
from ...model.units import MM_PER_M
from ..cache import Arrays, cached, digest
from ..progress import Progress, silent
from ..sensor_placement import sensors_at, sensors_on_midline
from ..skin import skin_of
from .attachment import default_fixed_nodes, described_fixed_nodes
from .description import MeshDescription, RigidDescription, known_meshes, read_sidecar, sidecar_of
from .files import TETGEN_SUFFIXES, VOLUME_SUFFIXES, read_tet_mesh
from .frame import MeshFrame, guessed_unit, parse_unit
from .raw import check_attached, checked_mesh
from .surfaces import SURFACE_SUFFIXES, read_surface
from .tetgen import announced_counts
from .warning import warn

HEADS = {"head": "medium", "head-small": "small", "head-medium": "medium", "head-large": "large"}
"""Names of the heads that ship with Lingual, and their sizes."""

SENSOR_REACH = 0.010
"""Farthest that a described sensor may lie from the surface on which it is put [m]."""

SURFACE_NODE_COUNT = 5500
"""Nodes of the mesh that fills a user's surface, about."""


def load_tongue(
    name_or_path: str | Path | None = None,
    progress: Progress | None = None,
    units: str | float | None = None,
) -> TongueModel:
    """The tongue that a user names.

    name_or_path: None or one of HEADS; or a mesh file (TetGen, what meshio reads, or a closed surface as
    .obj, .stl or .ply, which is filled with tetrahedra); the common path of a .node/.ele pair; or a
    directory with one mesh in it. progress: told how far the slow parts are. units: "m", "cm", "mm" or
    the metres in a unit of the file, when neither the file nor its description says.

    Raises LingualError for a name or file that cannot be used.
    """
    if name_or_path is None or str(name_or_path) in HEADS:
        from ..head import load_head  # its builder is slow to import and not needed for a mesh file

        return load_head(HEADS[str(name_or_path or "head")], progress)
    path = mesh_path(Path(name_or_path))
    description = describe(path)
    if units is not None:
        description = replace(description, unit=parse_unit(units))
    return _model(_read(path, description, progress or silent), description)


def mesh_path(path: Path) -> Path:
    """The mesh file that a path means: itself, the pair that it is the stem of, or the one in a directory.

    Raises LingualError when there is none, or more than one in a directory.
    """
    try:
        if path.is_dir():
            return _mesh_in(path)
        candidates = [path, *(path.with_name(path.name + suffix) for suffix in TETGEN_SUFFIXES)]
        found = [file for file in candidates if file.is_file()]
    except OSError as error:
        raise LingualError(f"{path} cannot be read ({error.strerror}): check the path.") from error
    if not found:
        raise LingualError(
            f"There is no mesh '{path}': give {', '.join(HEADS)} or the path of a mesh file or its folder."
        )
    return found[0]


def _mesh_in(folder: Path) -> Path:
    known = [k.stem for k in known_meshes() if _is_known(folder / f"{k.stem}.ele", k.name)]
    if len(known) > 1:
        warn(
            folder,
            f"it holds the meshes {' and '.join(known)}; {known[0]} is used, name the other by its path.",
        )
    if known:
        return folder / f"{known[0]}.ele"
    files = sorted(file for file in folder.iterdir() if file.is_file())
    volumes = [f for f in files if f.suffix.lower() in VOLUME_SUFFIXES and f.suffix.lower() != ".node"]
    surfaces = [f for f in files if f.suffix.lower() in SURFACE_SUFFIXES]
    found = volumes or surfaces
    if len(found) == 1:
        return found[0]
    if not found:
        raise LingualError(f"There is no mesh in {folder}: name a mesh file.")
    names = ", ".join(f.name for f in found[:5]) + (", ..." if len(found) > 5 else "")
    raise LingualError(f"{folder} holds {len(found)} meshes ({names}): name one of them.")


def _is_known(path: Path, name: str) -> bool:
    """Whether `path` is the published mesh `name`, by its stem and the counts that it announces."""
    known = next(k for k in known_meshes() if k.name == name)
    if path.suffix.lower() not in TETGEN_SUFFIXES or path.name[: -len(path.suffix)] != known.stem:
        return False
    return path.is_file() and announced_counts(path) == (known.node_count, known.tet_count)


def describe(path: Path) -> MeshDescription:
    """What is known about a mesh file: from its sidecar, from known_meshes.toml, or nothing but its name."""
    sidecar = sidecar_of(path)
    if sidecar.exists():
        return read_sidecar(sidecar, path.stem)
    for known in known_meshes():
        if _is_known(path, known.name):
            return known.description(path.parent)
    return MeshDescription(path.stem)


@dataclass(frozen=True, eq=False)
class _ReadMesh:
    """A checked mesh [m, head frame].

    frame: that of the file; source: the file. kept: index in the file, from 0, of each node; in_file: what
    the file calls its nodes; none of either for a filled surface.
    """

    mesh: TetMesh
    frame: MeshFrame
    source: str
    kept: NDArray[np.int64]
    in_file: range


def _read(path: Path, description: MeshDescription, progress: Progress) -> _ReadMesh:
    if path.suffix.lower() in SURFACE_SUFFIXES:
        vertices, triangles = read_surface(path)
        frame = _frame(description, vertices, str(path))
        filled = _filled(frame.to_head(vertices), triangles, path, progress)
        return _ReadMesh(filled, frame, str(path), np.empty(0, dtype=np.int64), range(0))
    raw = read_tet_mesh(path)
    finite = raw.nodes[np.isfinite(raw.nodes).all(axis=1)]
    frame = _frame(description, finite if len(finite) else np.zeros((1, 3)), raw.source)
    mesh, kept = checked_mesh(raw, frame.to_head(raw.nodes))
    in_file = range(raw.first_node, raw.first_node + len(raw.nodes))
    return _ReadMesh(mesh, frame, raw.source, kept, in_file)


def _frame(description: MeshDescription, points: NDArray[np.float64], source: str) -> MeshFrame:
    unit = description.unit
    return description.frame(guessed_unit(points, source) if unit is None else unit)


def _filled(
    vertices: NDArray[np.float64], triangles: NDArray[np.int32], path: Path, progress: Progress
) -> TetMesh:
    from ..tetrahedralise import tetrahedralise  # loads fTetWild, needed for surfaces only

    def build() -> Arrays:
        mesh = tetrahedralise(
            vertices, triangles, SURFACE_NODE_COUNT, progress=progress, name=f"surface {path}"
        )
        return {"nodes": mesh.nodes, "tets": mesh.tets}

    key = {"surface": digest(vertices, triangles), "node_count": SURFACE_NODE_COUNT}
    arrays = cached("filled-surface", key, build)
    return TetMesh(arrays["nodes"], arrays["tets"])


def _model(read: _ReadMesh, description: MeshDescription) -> TongueModel:
    fixed = _fixed_nodes(read, description)
    check_attached(read.mesh, fixed, read.source)
    return TongueModel(
        name=description.name,
        mesh=read.mesh,
        fixed_nodes=fixed,
        sensors=_sensors(read, description),
        skin=skin_of(read.mesh),
        rigid=tuple(_rigid_surface(part) for part in description.rigid),
    )


def _fixed_nodes(read: _ReadMesh, description: MeshDescription) -> NDArray[np.int64]:
    if description.fixed is None:
        return default_fixed_nodes(read.mesh, read.source)
    if not read.in_file and description.fixed.kind in ("nodes", "dofs"):
        raise LingualError(
            f"{read.source}: a surface is filled with new nodes, so fixed nodes cannot be given by number; "
            "give them as points."
        )
    return described_fixed_nodes(description.fixed, read.mesh, read.frame, read.kept, read.in_file)


def _sensors(read: _ReadMesh, description: MeshDescription) -> SensorLayout:
    wanted = description.sensors
    try:
        if wanted is None:
            return sensors_on_midline(read.mesh)
        if wanted.points is not None:
            points = read.frame.to_head(np.array(list(wanted.points.values())))
            sensors = sensors_at(read.mesh, points, tuple(wanted.points))
            _check_on_surface(sensors, points, read.mesh)
            return sensors
        assert wanted.arc_lengths is not None
        lengths = wanted.arc_lengths
        return sensors_on_midline(read.mesh, tuple(lengths.values()), tuple(lengths), wanted.midline)
    except LingualError as error:
        raise LingualError(f"{read.source}: {error}") from error


def _check_on_surface(sensors: SensorLayout, points: NDArray[np.float64], mesh: TetMesh) -> None:
    """Refuses points that are moved far to the surface: they are in another unit or other axes."""
    moved = np.linalg.norm(sensors.positions(mesh.nodes) - points, axis=1)
    worst = int(np.argmax(moved))
    if moved[worst] > SENSOR_REACH:
        raise LingualError(
            f"the sensor {sensors.names[worst]} is placed {moved[worst] * MM_PER_M:.0f} mm from the surface; "
            "give its point in the unit and axes of the mesh file."
        )


def _rigid_surface(part: RigidDescription) -> RigidSurface:
    vertices, triangles = read_surface(part.file)
    return RigidSurface(
        name=part.name,
        tissue=part.tissue,
        frame=part.moves_with,
        vertices=part.frame.to_head(vertices),
        triangles=triangles,
    )
