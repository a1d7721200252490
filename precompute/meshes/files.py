"""Tetrahedral meshes from files: TetGen pairs through our own reader, everything else through meshio."""

import contextlib
import io
from pathlib import Path

import meshio
import numpy as np

from ...model.errors import LingualError
from ...model.text_files import check_last_line_ended, read_bytes
from .raw import RawTetMesh
from .tetgen import read_tetgen

TETGEN_SUFFIXES = (".node", ".ele")

_LINE_BASED = (".vtk", ".mesh", ".inp")  # text forms that do not mark their own end
_SURFACE_ONLY = (".obj", ".stl", ".ply", ".off", ".svg", ".wkt")
_SOLIDS = ("hexahedron", "wedge", "pyramid")

VOLUME_SUFFIXES = (
    *TETGEN_SUFFIXES,
    *sorted(set(meshio.extension_to_filetypes) - {*TETGEN_SUFFIXES, *_SURFACE_ONLY}),
)
"""Endings of the files that read_tet_mesh may read."""


def read_tet_mesh(path: Path | str) -> RawTetMesh:
    """The tetrahedra in a file, in its unit and axes.

    TetGen .node/.ele (either names the pair) and what meshio reads. Of elements with nodes on their edges
    only the corners are used.

    Raises LingualError, naming file and, for TetGen, the line, when the file is missing, damaged or has
    no tetrahedra. The geometry is checked by checked_mesh.
    """
    path = Path(path)
    if path.suffix.lower() in TETGEN_SUFFIXES:
        return read_tetgen(path)
    if not any("".join(path.suffixes[i:]).lower() in VOLUME_SUFFIXES for i in range(len(path.suffixes))):
        read_bytes(path, 1)
        raise LingualError(
            f"{path}: a file ending in '{path.suffix}' is not known as a tetrahedral mesh; "
            "give .node and .ele, .vtk, .vtu, .msh, .mesh, .inp or another volume format of meshio."
        )
    mesh = read_with_meshio(path)
    solids = [block for block in mesh.cells if block.type.startswith(("tetra", *_SOLIDS))]
    tets = [block.data[:, :4] for block in solids if block.type.startswith("tetra")]
    if len(tets) < len(solids) or not tets or sum(map(len, tets)) == 0:
        kinds = ", ".join(sorted({block.type for block in mesh.cells if len(block.data)})) or "nothing"
        raise LingualError(
            f"{path} must be made of tetrahedra, but it holds {kinds}: "
            "give a tetrahedral mesh, or its closed surface as .obj, .stl or .ply."
        )
    points = np.asarray(mesh.points, dtype=np.float64)
    if points.ndim != 2 or points.shape[1] != 3:
        raise LingualError(f"{path}: its points have shape {points.shape}; three coordinates are needed.")
    return RawTetMesh(points, np.concatenate(tets).astype(np.int64), str(path))


def read_with_meshio(path: Path) -> meshio.Mesh:
    """What meshio reads, without its printing and without its exit from the program on a bad file."""
    read_bytes(path, 1)
    if path.suffix.lower() in _LINE_BASED:
        content = path.read_bytes()
        if b"\0" not in content:
            check_last_line_ended(path, content.decode("latin-1"))
    printed = io.StringIO()
    try:
        with (
            contextlib.redirect_stdout(printed),
            contextlib.redirect_stderr(printed),
            np.errstate(all="ignore"),
        ):
            mesh = meshio.read(path)
    except (Exception, SystemExit) as error:  # a damaged file raises anything in meshio's readers
        reason = " ".join(str(error).split())
        reason = reason if reason not in ("", "1") else type(error).__name__
        raise LingualError(
            f"{path} cannot be read as a mesh ({reason[:120]}): it is damaged or cut short."
        ) from error
    return mesh
