"""TetGen's pair of text files: NAME.node with the points, NAME.ele with the tetrahedra.

.node: a line of counts (points, 3, attributes, boundary markers 0 or 1), then number, x, y, z, attributes and
marker of each point. .ele: a line of counts (elements, 4 or 10 points each, attributes), then number, points
and attributes of each element. Numbers start at 0 or 1, as the first point has it. # begins a comment.
"""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...model.errors import LingualError
from ...model.text_files import check_last_line_ended, integer, read_bytes, read_text, real, token_lines
from .raw import RawTetMesh

_COPY = "the file is damaged or cut short: copy it again"


def read_tetgen(path: Path) -> RawTetMesh:
    """Reads the mesh of which `path` names the .node or the .ele file.

    Raises LingualError, naming file and line, when a file or its companion is missing, or when they do
    not hold what their first lines announce.
    """
    node_path, ele_path = companions(path)
    for companion, other in ((node_path, ele_path), (ele_path, node_path)):
        if other == path and not companion.exists():
            raise LingualError(f"There is no file {companion}, which {path.name} needs beside it.")
    first_node, nodes = read_nodes(node_path)
    first_element, tets = _read_elements(ele_path, first_node)
    return RawTetMesh(nodes, tets, str(ele_path), first_node, first_element)


def companions(path: Path) -> tuple[Path, Path]:
    """The .node and the .ele file of a pair, from either."""
    name = path.name[: -len(path.suffix)]
    return path.with_name(f"{name}.node"), path.with_name(f"{name}.ele")


def announced_counts(path: Path) -> tuple[int, int] | None:
    """Numbers of points and elements that a pair announces; None when they cannot be read."""
    counts = []
    for file in companions(path):
        try:
            read_bytes(file, 1)
            with open(file, encoding="ascii", errors="replace") as text:
                counts.append(int(next(token_lines(text.read(4096)))[1][0]))
        except (LingualError, ValueError, StopIteration):
            return None
    return counts[0], counts[1]


def read_nodes(path: Path) -> tuple[int, NDArray[np.float64]]:
    """Number of the first point, and all points (node_count, 3), in the file's unit and axes.

    A file without the line of counts (as the hexahedral meshes of ArtiSynth have it) is read to its end.
    """
    text = read_text(path)
    lines = list(token_lines(text))
    count, width = len(lines), 4
    if len(lines) > 1 and not _is_point(lines[0][1]):
        line, header = lines.pop(0)
        numbers = [integer(path, line, token) for token in header]
        if len(numbers) > 1 and numbers[1] != 3:
            raise LingualError(f"{path}, line {line}: the points have dimension {numbers[1]}; 3 is needed.")
        count, width = numbers[0], 4 + sum(numbers[2:])
    _check_count(path, lines, count, "points")
    check_last_line_ended(path, text)
    first = integer(path, lines[0][0], lines[0][1][0])
    _check_first(path, lines[0][0], first)
    points = np.empty((count, 3))
    for i, (line, tokens) in enumerate(lines):
        _check_line(path, line, tokens, width, first + i)
        points[i] = [real(path, line, token) for token in tokens[1:4]]
        if not np.isfinite(points[i]).all():
            raise LingualError(f"{path}, line {line}: a coordinate is not finite; repair the mesh.")
    return first, points


def _is_point(tokens: list[str]) -> bool:
    """Whether a first line is already a point: four numbers of which one has a decimal point."""
    return len(tokens) == 4 and any("." in token for token in tokens)


def _read_elements(path: Path, first_node: int) -> tuple[int, NDArray[np.int64]]:
    """Number of the first element, and all elements (tet_count, 4) as indices from 0."""
    text = read_text(path)
    lines = list(token_lines(text))
    if not lines:
        raise LingualError(f"{path} has no line of counts: it is not a TetGen file.")
    line, header = lines.pop(0)
    numbers = [integer(path, line, token) for token in header]
    corners = numbers[1] if len(numbers) > 1 else 4
    if corners not in (4, 10):
        raise LingualError(
            f"{path}, line {line}: the elements have {corners} points each; tetrahedra have 4 (or 10)."
        )
    _check_count(path, lines, numbers[0], "elements")
    check_last_line_ended(path, text)
    first = integer(path, lines[0][0], lines[0][1][0])
    _check_first(path, lines[0][0], first)
    width = 1 + corners + sum(numbers[2:])
    tets = np.empty((len(lines), 4), dtype=np.int64)
    for i, (line, tokens) in enumerate(lines):
        _check_line(path, line, tokens, width, first + i)
        tets[i] = [integer(path, line, token) for token in tokens[1:5]]
    return first, tets - first_node


def _check_count(path: Path, lines: list[tuple[int, list[str]]], count: int, what: str) -> None:
    if not lines or count < 1:
        raise LingualError(f"{path} has no {what}: {_COPY}.")
    if len(lines) < count:
        raise LingualError(
            f"{path}, line {lines[-1][0]}: the file ends after {len(lines)} {what}, but its first "
            f"line announces {count}; it is cut short: copy it again."
        )
    if len(lines) > count:
        raise LingualError(
            f"{path}, line {lines[count][0]}: there are more than the {count} {what} that the first line "
            "announces; correct the count."
        )


def _check_first(path: Path, line: int, first: int) -> None:
    if first not in (0, 1):
        raise LingualError(f"{path}, line {line}: numbers start at {first}; they must start at 0 or 1.")


def _check_line(path: Path, line: int, tokens: list[str], width: int, number: int) -> None:
    if len(tokens) != width:
        raise LingualError(f"{path}, line {line}: {len(tokens)} values where {width} are needed; {_COPY}.")
    if tokens[0] != str(number) and integer(path, line, tokens[0]) != number:
        raise LingualError(f"{path}, line {line}: number {tokens[0]} stands where {number} is due; {_COPY}.")
