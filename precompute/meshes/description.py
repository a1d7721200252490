"""What a mesh file does not say: unit, axes, which nodes bone holds, where the coils sit, the rigid parts.

Read from `known_meshes.toml` for published meshes, and from NAME.lingual.toml beside a mesh of a user's own;
docs/formats.md describes the keys.
"""

import tomllib
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

from ...model.errors import LingualError
from ...model.text_files import read_text
from .frame import MeshFrame, parse_unit

KNOWN_MESHES = Path(__file__).with_name("known_meshes.toml")
SIDECAR_SUFFIX = ".lingual.toml"

Table = dict[str, Any]


@dataclass(frozen=True)
class FixedDescription:
    """Which nodes bone holds.

    kind: "nodes", numbers as in the mesh file; "dofs", a count and then 3 number + coordinate, from 0;
    "points", every node within `within` [m] of a point; "numbers-in", the same with the points of another
    node file that the numbers name.
    files: text files of numbers; numbers: numbers given directly; points: [file unit] in `frame`.
    numbers_in: node file of "numbers-in", whose coordinates are in `frame`; first_number: what its first
    point is called in the lists.
    """

    kind: str
    files: tuple[Path, ...] = ()
    numbers: tuple[int, ...] = ()
    points: tuple[tuple[float, float, float], ...] = ()
    numbers_in: Path | None = None
    first_number: int = 0
    frame: MeshFrame | None = None
    within: float = 0.0025

    @property
    def all_files(self) -> tuple[Path, ...]:
        return self.files if self.numbers_in is None else (*self.files, self.numbers_in)


@dataclass(frozen=True)
class SensorDescription:
    """Where the coils sit: points [file unit], or distances behind the tip and the midline [m]."""

    points: dict[str, tuple[float, float, float]] | None = None
    arc_lengths: dict[str, float] | None = None
    midline: float | None = None


@dataclass(frozen=True)
class RigidDescription:
    """A surface file that is a rigid part of the mouth; see RigidSurface."""

    name: str
    file: Path
    tissue: str
    moves_with: str
    frame: MeshFrame


@dataclass(frozen=True)
class MeshDescription:
    """Everything about a mesh file that it does not say; None where that is left to defaults."""

    name: str
    unit: float | None = None
    axes: str = "+x +y +z"
    origin: tuple[float, float, float] = (0.0, 0.0, 0.0)
    fixed: FixedDescription | None = None
    sensors: SensorDescription | None = None
    rigid: tuple[RigidDescription, ...] = ()

    def frame(self, unit: float) -> MeshFrame:
        return MeshFrame(unit, self.axes, self.origin)


@dataclass(frozen=True)
class KnownMesh:
    """How a published mesh is recognised, and its table in known_meshes.toml."""

    name: str
    stem: str
    node_count: int
    tet_count: int
    table: Table

    def description(self, folder: Path) -> MeshDescription:
        """Its description when it lies in `folder`; what needs a file that is not there is left out."""
        found = _Reader(KNOWN_MESHES, folder).description(self.name, self.table)
        fixed = found.fixed
        if fixed is not None and not all(file.is_file() for file in fixed.all_files):
            fixed = None
        return replace(found, fixed=fixed, rigid=tuple(part for part in found.rigid if part.file.is_file()))


@cache
def known_meshes() -> tuple[KnownMesh, ...]:
    """The meshes of known_meshes.toml, in its order."""
    tables = tomllib.loads(KNOWN_MESHES.read_text(encoding="utf-8"))
    known = []
    for name, table in tables.items():
        identity = {key: table.pop(key) for key in ("stem", "node_count", "tet_count")}
        original = table.pop("same_as", None)
        known.append(KnownMesh(name, **identity, table=tables[original] if original else table))
    return tuple(known)


def sidecar_of(mesh_path: Path) -> Path:
    """Where the description of a user's own mesh is looked for: NAME.lingual.toml beside NAME.ele."""
    return mesh_path.with_name(mesh_path.name[: -len(mesh_path.suffix)] + SIDECAR_SUFFIX)


def read_sidecar(path: Path, name: str) -> MeshDescription:
    """A user's description of the mesh `name`. Raises LingualError, naming the file and the key or line."""
    try:
        table = tomllib.loads(read_text(path))
    except tomllib.TOMLDecodeError as error:
        raise LingualError(f"{path} is not valid TOML ({error}): correct it.") from error
    return _Reader(path, path.parent).description(name, table)


class _Reader:
    """Turns tables into descriptions; messages name the file `path`, file names are relative to `folder`."""

    def __init__(self, path: Path, folder: Path) -> None:
        self.path = path
        self.folder = folder

    def description(self, name: str, table: Table) -> MeshDescription:
        self._check_keys(table, "", ("unit", "axes", "origin", "fixed", "sensors", "rigid"))
        frame = self._frame(table, "")
        fixed, sensors = table.get("fixed"), table.get("sensors")
        rigid = table.get("rigid", [])
        return MeshDescription(
            name=name,
            unit=frame.unit if "unit" in table else None,
            axes=frame.axes,
            origin=frame.origin,
            fixed=self._fixed(self._table(fixed, "fixed"), frame) if fixed is not None else None,
            sensors=self._sensors(self._table(sensors, "sensors")) if sensors is not None else None,
            rigid=tuple(
                self._rigid(self._table(part, "rigid"))
                for part in self._typed(rigid, "rigid", list, "a list")
            ),
        )

    def _fixed(self, table: Table, mesh_frame: MeshFrame) -> FixedDescription:
        keys = ("format", "files", "numbers", "points", "numbers_in", "first_number", "within_mm")
        self._check_keys(table, "fixed.", (*keys, "unit", "axes", "origin"))
        kind = table.get("format", "points" if "points" in table else "nodes")
        if kind not in ("nodes", "dofs", "points", "numbers-in"):
            raise self._error("fixed.format", "must be 'nodes', 'dofs', 'points' or 'numbers-in'")
        own_frame = any(key in table for key in ("unit", "axes", "origin"))
        names = self._typed(table.get("files", []), "fixed.files", list, "a list of file names")
        points = self._typed(table.get("points", []), "fixed.points", list, "a list of points")
        numbers = self._typed(table.get("numbers", []), "fixed.numbers", list, "a list of numbers")
        description = FixedDescription(
            kind=kind,
            files=tuple(self._file(name, "fixed.files") for name in names),
            numbers=tuple(self._typed(n, "fixed.numbers", int, "whole numbers") for n in numbers),
            points=tuple(self._point(point, "fixed.points") for point in points),
            numbers_in=self._file(table["numbers_in"], "fixed.numbers_in") if "numbers_in" in table else None,
            first_number=self._typed(table.get("first_number", 0), "fixed.first_number", int, "0 or 1"),
            frame=self._frame(table, "fixed.") if own_frame else None,
            within=self._number(table.get("within_mm", 2.5), "fixed.within_mm") / 1e3,
        )
        if not (description.files or description.numbers or description.points):
            raise self._error("fixed", "must have 'files', 'numbers' or 'points'")
        if kind == "numbers-in" and description.numbers_in is None:
            raise self._error("fixed.numbers_in", "must name the node file that the numbers refer to")
        return description

    def _sensors(self, table: Table) -> SensorDescription:
        self._check_keys(table, "sensors.", ("points", "arc_lengths_mm", "midline_mm"))
        if ("points" in table) == ("arc_lengths_mm" in table):
            raise self._error("sensors", "must have either 'points' or 'arc_lengths_mm'")
        midline = table.get("midline_mm")
        if "points" in table:
            points = self._table(table["points"], "sensors.points")
            return SensorDescription({n: self._point(p, f"sensors.points.{n}") for n, p in points.items()})
        lengths = self._table(table["arc_lengths_mm"], "sensors.arc_lengths_mm")
        return SensorDescription(
            arc_lengths={n: self._number(v, f"sensors.arc_lengths_mm.{n}") / 1e3 for n, v in lengths.items()},
            midline=None if midline is None else self._number(midline, "sensors.midline_mm") / 1e3,
        )

    def _rigid(self, table: Table) -> RigidDescription:
        keys = ("name", "file", "tissue", "frame")
        self._check_keys(table, "rigid.", (*keys, "unit", "axes", "origin"))
        for key in (*keys, "unit"):
            if key not in table:
                raise self._error(f"rigid.{key}", "is missing")
        if table["tissue"] not in ("bone", "tooth", "mucosa"):
            raise self._error("rigid.tissue", "must be 'bone', 'tooth' or 'mucosa'")
        if table["frame"] not in ("jaw", "head"):
            raise self._error("rigid.frame", "must be 'jaw' or 'head'")
        name = self._typed(table["name"], "rigid.name", str, "a text")
        file = self._file(table["file"], "rigid.file")
        return RigidDescription(name, file, table["tissue"], table["frame"], self._frame(table, "rigid."))

    def _frame(self, table: Table, where: str) -> MeshFrame:
        try:
            return MeshFrame(
                unit=parse_unit(
                    self._typed(table.get("unit", 1.0), f"{where}unit", (str, int, float), "a unit")
                ),
                axes=self._typed(table.get("axes", "+x +y +z"), f"{where}axes", str, "a text"),
                origin=self._point(table.get("origin", [0.0, 0.0, 0.0]), f"{where}origin"),
            )
        except LingualError as error:
            if str(error).startswith(str(self.path)):
                raise
            raise LingualError(f"{self.path}: {error}") from error

    def _point(self, value: Any, key: str) -> tuple[float, float, float]:
        numbers = self._typed(value, key, list, "three numbers")
        if len(numbers) != 3:
            raise self._error(key, "must be three numbers")
        x, y, z = (self._number(number, key) for number in numbers)
        return x, y, z

    def _number(self, value: Any, key: str) -> float:
        number = float(self._typed(value, key, (int, float), "a number"))
        if not abs(number) < float("inf"):
            raise self._error(key, "must be a finite number")
        return number

    def _file(self, value: Any, key: str) -> Path:
        return self.folder / self._typed(value, key, str, "a file name")

    def _table(self, value: Any, key: str) -> Table:
        return self._typed(value, key, dict, "a table")

    def _typed(self, value: Any, key: str, kind: Any, what: str) -> Any:
        if not isinstance(value, kind) or isinstance(value, bool):
            raise self._error(key, f"must be {what}")
        return value

    def _check_keys(self, table: Table, where: str, allowed: tuple[str, ...]) -> None:
        for key in table:
            if key not in allowed:
                raise self._error(f"{where}{key}", f"is not known here; known are {', '.join(allowed)}")

    def _error(self, key: str, text: str) -> LingualError:
        return LingualError(f"{self.path}: '{key}' {text}.")
