"""Which nodes of a mesh bone holds: from its description, or by a rule where there is none."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ...model.errors import LingualError
from ...model.tet_mesh import TetMesh
from ...model.text_files import integer, read_text, token_lines
from .description import FixedDescription
from .frame import MeshFrame
from .tetgen import read_nodes
from .warning import warn

# The rule, as shares of the mesh's height and of its base's length. On Luo's tongue it gives 1,315 nodes, of
# which 1,233 are among the 1,251 that the author fixed.
_BASE_HEIGHT = 0.15
_CHIN_HEIGHT = 0.40
_CHIN_LENGTH = 0.15


def described_fixed_nodes(
    description: FixedDescription,
    mesh: TetMesh,
    frame: MeshFrame,
    kept: NDArray[np.int64],
    in_file: range,
) -> NDArray[np.int64]:
    """Indices in `mesh` of the nodes that the description fixes, sorted.

    frame: that of the mesh file; kept: index in the file, from 0, of each node of the mesh; in_file: what
    the file calls its nodes.

    Raises LingualError, naming file and line, for numbers that are no nodes, or when nothing is fixed.
    """
    own = description.frame or frame
    if description.kind in ("nodes", "dofs"):
        numbers = _numbers(description, 3 if description.kind == "dofs" else 1)
        index = numbers // 3 if description.kind == "dofs" else numbers - in_file.start
        bad = np.flatnonzero((index < 0) | (index >= len(in_file)))
        if len(bad):
            raise LingualError(
                f"{_origin(description)}: {numbers[bad[0]]} is no node of the mesh; "
                f"it has {len(in_file)} nodes, numbered from {in_file.start}."
            )
        fixed = np.flatnonzero(np.isin(kept, index))
    else:
        fixed = _near(mesh, own.to_head(_points(description)), description.within)
    if len(fixed) < 3:
        raise LingualError(
            f"{_origin(description)}: it fixes {len(fixed)} nodes of the mesh; at least 3 must be."
        )
    return fixed


def default_fixed_nodes(mesh: TetMesh, source: str) -> NDArray[np.int64]:
    """The base and the lower front, where the tongue is attached to hyoid and chin; told by a MeshWarning."""
    x, z = mesh.nodes[:, 0], mesh.nodes[:, 2]
    height = (z - z.min()) / np.ptp(z)
    base = height < _BASE_HEIGHT
    front = x > x[base].max() - _CHIN_LENGTH * np.ptp(x[base])
    fixed = np.flatnonzero(base | (front & (height < _CHIN_HEIGHT)))
    warn(
        source,
        f"no fixed nodes are given, so the {len(fixed)} at the base and behind the chin are held; "
        "name them in a .lingual.toml file beside the mesh.",
    )
    return fixed


def _near(mesh: TetMesh, points: NDArray[np.float64], within: float) -> NDArray[np.int64]:
    distance, _ = cKDTree(points).query(mesh.nodes, distance_upper_bound=within)
    return np.flatnonzero(np.isfinite(distance))


def _points(description: FixedDescription) -> NDArray[np.float64]:
    """Points (n, 3) of "points" and "numbers-in", in the file unit and axes that the description names."""
    if description.numbers_in is None:
        if not description.points:
            raise LingualError(f"{_origin(description)}: 'points' are missing for fixed nodes by position.")
        return np.array(description.points)
    _, points = read_nodes(description.numbers_in)
    index = _numbers(description, 1) - description.first_number
    bad = np.flatnonzero((index < 0) | (index >= len(points)))
    if len(bad):
        raise LingualError(
            f"{_origin(description)}: number {index[bad[0]] + description.first_number} is no point of "
            f"{description.numbers_in}."
        )
    return points[index]


def _numbers(description: FixedDescription, per_node: int) -> NDArray[np.int64]:
    """All numbers of the files and of the description; per_node = 3: files begin with their count."""
    numbers = list(description.numbers)
    for path in description.files:
        found = _read_numbers(path)
        if per_node == 3:
            count, found = found[0], found[1:]
            if count != len(found):
                raise LingualError(
                    f"{path}: {count} numbers are announced in line 1, but {len(found)} follow; "
                    "it is cut short: copy it again."
                )
        numbers += found
    return np.unique(np.array(numbers, dtype=np.int64))


def _read_numbers(path: Path) -> list[int]:
    """The whole numbers in a text file, with blanks, commas or line ends between them."""
    text = read_text(path).replace(",", " ")
    numbers = [integer(path, line, token) for line, tokens in token_lines(text) for token in tokens]
    if not numbers:
        raise LingualError(f"{path} holds no numbers: copy it again.")
    return numbers


def _origin(description: FixedDescription) -> str:
    """What messages call the source of the numbers."""
    return str(description.files[0]) if description.files else "The description of the mesh"
