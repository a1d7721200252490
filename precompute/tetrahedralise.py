"""Tetrahedral mesh inside a closed triangle surface, through fTetWild (Hu et al. 2020).

Used for the head that ships with the product and for surfaces that users bring. The node count is met by
repeating the meshing with a corrected edge length: nodes scale as length^-3 inside and as length^-2 on the
surface, so a secant step on log(count) against log(length) converges in a few repetitions. fTetWild is not
reproducible: two runs on the same surface give meshes of the same quality that differ in detail, which is why
meshes are cached, not made again.
"""

import logging
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.csgraph import breadth_first_order, connected_components

from ..model.errors import LingualError
from ..model.tet_mesh import TetMesh, signed_volumes
from .progress import Progress, silent

log = logging.getLogger(__name__)

TOLERANCE = 0.08
"""Accepted relative difference between the node count asked for and the one obtained."""

_ATTEMPTS = 5
_PROCESS = Path(__file__).with_name("tetwild_process.py")
_NODES_PER_CUBE = 2.1  # nodes per (edge length)^3 that fTetWild makes in a body of a few thousand nodes


def tetrahedralise(
    vertices: NDArray[np.floating],
    triangles: NDArray[np.integer],
    node_count: int = 5500,
    envelope: float = 0.055,
    progress: Progress = silent,
    name: str = "surface",
) -> TetMesh:
    """Fills a closed surface with about `node_count` nodes.

    vertices: (n, 3) [m]; triangles: (m, 3), either orientation. envelope: how far the mesh may leave the
    surface, in edge lengths; if much less, the surface's curvature dictates the node count. name: what
    messages call the surface.
    Returns the mesh whose node count came closest (within 8 % as a rule), positively oriented, without
    unused nodes.

    Raises LingualError for a surface that is empty, open, not finite or without volume.
    """
    points, faces = closed_surface(vertices, triangles, name)
    scale = float(np.linalg.norm(np.ptp(points, axis=0)))
    points = points / scale  # fTetWild's tolerances are relative, but its defaults suit sizes near one
    length = (enclosed_volume(points, faces) * _NODES_PER_CUBE / node_count) ** (1.0 / 3.0)
    tried: list[tuple[float, int]] = []
    best: tuple[float, NDArray[np.float64], NDArray[np.int32]] | None = None
    for attempt in range(_ATTEMPTS):
        progress(f"tetrahedra, attempt {attempt + 1}", attempt / _ATTEMPTS)
        nodes, tets = _fill(points, faces, length, envelope * length, name)
        error = abs(len(nodes) / node_count - 1.0)
        if best is None or error < best[0]:
            best = (error, nodes, tets)
        if error < TOLERANCE:
            break
        tried.append((np.log(length), len(nodes)))
        length = _next_length(tried, node_count)
    assert best is not None
    progress("tetrahedra", 1.0)
    return TetMesh(best[1] * scale, best[2])


def closed_surface(
    vertices: NDArray[np.floating], triangles: NDArray[np.integer], name: str = "surface"
) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """The surface with coincident vertices merged, unused ones dropped and all triangles facing outward.

    Raises LingualError, naming the surface, when it is empty, not finite, open or without volume.
    """
    points, faces = merged(np.asarray(vertices, dtype=np.float64), np.asarray(triangles))
    if len(faces) < 4:
        raise LingualError(
            f"The {name} has no closed triangle surface to fill: give it at least 4 triangles."
        )
    if not np.isfinite(points).all():
        raise LingualError(f"The {name} has a vertex whose coordinates are not finite: repair it.")
    open_count = len(edge_use(faces)[1])
    if open_count:
        raise LingualError(
            f"The {name} is not closed: {open_count} of its edges have a triangle on one side only; "
            "fill its holes before it can be tetrahedralised."
        )
    faces = _outward(points, faces)
    if enclosed_volume(points, faces) <= 1e-9 * np.ptp(points, axis=0).max() ** 3:
        raise LingualError(f"The {name} encloses no volume: it is flat or turned inside out in places.")
    return points, faces


def enclosed_volume(vertices: NDArray[np.float64], triangles: NDArray[np.integer]) -> float:
    """Signed volume inside an oriented closed surface, in the cube of the vertices' unit."""
    a, b, c = (vertices[triangles[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def _fill(
    points: NDArray[np.float64], faces: NDArray[np.int32], length: float, envelope: float, name: str
) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """One run of fTetWild: nodes (n, 3), tets (m, 4), positively oriented, without unused nodes."""
    with tempfile.TemporaryDirectory(prefix="lingual-") as folder:
        source, target = Path(folder, "surface.npz"), Path(folder, "mesh.npz")
        np.savez(source, vertices=points, triangles=faces, edge_length=length, envelope=envelope)
        command = [sys.executable, "-P", str(_PROCESS), str(source), str(target)]
        run = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
        if run.returncode != 0 or not target.exists():
            log.debug("fTetWild ended with %s: %s", run.returncode, run.stderr)
            last = run.stderr.strip().splitlines()[-1:] or [f"it ended with code {run.returncode}"]
            raise LingualError(f"The {name} cannot be tetrahedralised ({last[0]}): repair the surface.")
        with np.load(target, allow_pickle=False) as mesh:
            nodes, tets = mesh["nodes"], mesh["tets"]
    if len(tets) == 0:
        raise LingualError(f"The {name} cannot be tetrahedralised: no element lies inside it.")
    used, compact = np.unique(tets, return_inverse=True)
    nodes, tets = nodes[used], compact.reshape(-1, 4).astype(np.int32)
    negative = signed_volumes(nodes, tets) < 0.0
    tets[negative] = tets[negative][:, [0, 2, 1, 3]]
    return nodes, tets


def _next_length(tried: list[tuple[float, int]], node_count: int) -> float:
    """Edge length from the last two attempts by the secant rule, with slope -3 after the first."""
    log_length, count = tried[-1]
    slope = -3.0
    if len(tried) > 1:
        before, count_before = tried[-2]
        if count != count_before and abs(log_length - before) > 1e-6:
            slope = (np.log(count) - np.log(count_before)) / (log_length - before)
            slope = float(np.clip(slope, -4.0, -1.0))
    return float(np.exp(log_length + np.clip((np.log(node_count) - np.log(count)) / slope, -1.0, 1.0)))


def merged(
    points: NDArray[np.float64], faces: NDArray[np.integer]
) -> tuple[NDArray[np.float64], NDArray[np.int32]]:
    """Vertices closer than 1e-6 of the size become one (STL repeats them); degenerate triangles go."""
    if len(points) == 0 or len(faces) == 0 or not np.isfinite(points).all():
        return points, np.asarray(faces, dtype=np.int32).reshape(-1, 3)
    cell = 1e-6 * max(float(np.ptp(points, axis=0).max()), 1e-30)
    _, first, inverse = np.unique(np.round(points / cell), axis=0, return_index=True, return_inverse=True)
    faces = inverse.reshape(-1)[faces]
    whole = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    used, faces = np.unique(faces[whole], return_inverse=True)
    return points[first[used]], faces.reshape(-1, 3).astype(np.int32)


def edge_use(faces: NDArray[np.int32]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """For every edge joining two triangles those two, (k, 2); and the edges of an odd number, (open, 2)."""
    edges = np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    unique, inverse, count = np.unique(edges, axis=0, return_inverse=True, return_counts=True)
    order = np.argsort(inverse.reshape(-1), kind="stable")
    starts = np.cumsum(count) - count
    pairs = starts[count == 2]
    return np.stack([order[pairs] // 3, order[pairs + 1] // 3], axis=1), unique[count % 2 == 1]


def _outward(points: NDArray[np.float64], faces: NDArray[np.int32]) -> NDArray[np.int32]:
    """Makes neighbouring triangles agree, then turns each connected piece so that its volume is positive."""
    joined, _ = edge_use(faces)
    directed = np.unique(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=0)
    faces = faces.copy()
    if len(directed) < 3 * len(faces):
        faces = agreeing_triangles(faces, joined)
    graph = sp.csr_array((np.ones(len(joined)), joined.T), shape=(len(faces), len(faces)))
    piece_count, piece = connected_components(graph, directed=False)
    for p in range(piece_count):
        mine = piece == p
        if enclosed_volume(points, faces[mine]) < 0.0:
            faces[mine] = faces[mine][:, ::-1]
    return faces


def agreeing_triangles(faces: NDArray[np.int32], joined: NDArray[np.int64]) -> NDArray[np.int32]:
    """Flips triangles, walking over shared edges, until the two at each edge run it in opposite senses."""
    graph = sp.csr_array((np.ones(len(joined)), joined.T), shape=(len(faces), len(faces)))
    _, piece = connected_components(graph, directed=False)
    for start in np.unique(piece, return_index=True)[1]:
        order, before = breadth_first_order(graph, start, directed=False)
        for i in order[1:]:
            mine = faces[i].tolist()
            other = faces[before[i]].tolist()
            runs = set(zip(other, other[1:] + other[:1], strict=True))
            if any(edge in runs for edge in zip(mine, mine[1:] + mine[:1], strict=True)):
                faces[i] = faces[i][::-1]
    return faces
