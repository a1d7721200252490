"""Triangle surfaces from files: .obj by our own reader, which knows line numbers, .stl and .ply by meshio."""

import re
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...model.errors import LingualError
from ...model.text_files import check_last_line_ended, integer, read_bytes, read_text, real
from .files import read_with_meshio

SURFACE_SUFFIXES = (".obj", ".stl", ".ply")

_COPY = "it is damaged or cut short: copy it again"

Surface = tuple[NDArray[np.float64], NDArray[np.int32]]


def read_surface(path: Path | str) -> Surface:
    """Vertices (n, 3) and triangles (m, 3) of a surface, in the file's unit and axes.

    Faces with more corners are cut into triangles, as fans from their first corner.

    Raises LingualError, naming the file (and for .obj the line), when it is missing, damaged or has no faces.
    """
    path = Path(path)
    suffix = path.suffix.lower()
    if suffix not in SURFACE_SUFFIXES:
        raise LingualError(f"{path}: a surface must end in {', '.join(SURFACE_SUFFIXES)}.")
    vertices, triangles = _read_obj(path) if suffix == ".obj" else _read_by_meshio(path)
    if len(triangles) == 0:
        raise LingualError(f"{path} has no faces: export the surface again.")
    if vertices.shape[1:] != (3,):
        raise LingualError(f"{path}: vertices have shape {vertices.shape}; three coordinates are needed.")
    bad = np.flatnonzero(~np.isfinite(vertices).all(axis=1))
    if len(bad):
        raise LingualError(f"{path}: vertex {bad[0]} has a coordinate that is not a finite number.")
    if triangles.min() < 0 or triangles.max() >= len(vertices):
        wrong = triangles.min() if triangles.min() < 0 else triangles.max()
        raise LingualError(
            f"{path}: a face names vertex {wrong}, but the vertices are 0 to {len(vertices) - 1}."
        )
    return vertices, triangles.astype(np.int32)


def _read_by_meshio(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    read_bytes(path, 1)
    announced = _announced_faces(path)
    mesh = read_with_meshio(path)
    faces = [block.data for block in mesh.cells if block.type in ("triangle", "quad", "polygon")]
    if announced is not None and sum(map(len, faces)) != announced:
        raise LingualError(
            f"{path}: {announced} faces are announced, but {sum(map(len, faces))} follow; {_COPY}."
        )
    fans = [_fan(np.asarray(block, dtype=np.int64)) for block in faces if len(block)]
    triangles = np.concatenate(fans) if fans else np.empty((0, 3), dtype=np.int64)
    return np.asarray(mesh.points, dtype=np.float64), triangles


def _announced_faces(path: Path) -> int | None:
    """Number of faces that a .ply announces, None for .stl.

    Raises LingualError where meshio would not notice that the file is cut short: a .ply without its
    whole header, in which meshio does not return, and a text .stl without its end.
    """
    content = path.read_bytes()
    if path.suffix.lower() == ".stl":
        if content.startswith(b"solid") and b"\0" not in content and b"endsolid" not in content:
            raise LingualError(f"{path}: the 'endsolid' at its end is missing; {_COPY}.")
        return None
    header, end, _ = content.partition(b"end_header")
    found = re.search(rb"element\s+face\s+(\d{1,9})\s", header)
    if not content.startswith(b"ply") or not end or found is None:
        raise LingualError(f"{path}: it has no PLY header that ends and announces faces; {_COPY}.")
    return int(found.group(1))


def _fan(faces: NDArray[np.int64]) -> NDArray[np.int64]:
    """Triangles of faces (m, k): (m (k - 2), 3)."""
    count = faces.shape[1] - 2
    corners = [(0, i + 1, i + 2) for i in range(count)]
    return faces[:, corners].reshape(-1, 3)


def _read_obj(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    vertices: list[list[float]] = []
    triangles: list[list[int]] = []
    content = read_text(path)
    check_last_line_ended(path, content)
    for line, text in enumerate(content.splitlines(), start=1):
        tokens = text.partition("#")[0].split()
        if not tokens:
            continue
        if tokens[0] == "v":
            if len(tokens) < 4:
                raise LingualError(
                    f"{path}, line {line}: a vertex needs three coordinates; the file is damaged."
                )
            vertices.append([real(path, line, token) for token in tokens[1:4]])
        elif tokens[0] == "f":
            corners = [_corner(path, line, token, len(vertices)) for token in tokens[1:]]
            if len(corners) < 3:
                raise LingualError(f"{path}, line {line}: a face needs three corners; the file is damaged.")
            triangles += [[corners[0], b, c] for b, c in pairwise(corners[1:])]
    return np.array(vertices).reshape(-1, 3), np.array(triangles, dtype=np.int64).reshape(-1, 3)


def _corner(path: Path, line: int, token: str, vertex_count: int) -> int:
    """Index from 0 of a corner such as 7, 7/2, 7//3 or -1 (the latest vertex)."""
    number = integer(path, line, token.partition("/")[0])
    index = number - 1 if number > 0 else vertex_count + number
    if number == 0 or index < 0:
        raise LingualError(f"{path}, line {line}: a face names vertex {number}, which does not exist.")
    return index
