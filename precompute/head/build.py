"""Builds the head from its description, stores it as plain arrays and turns those into a TongueModel.

`python -m lingual.precompute.head` regenerates the medium head that ships with the package.
"""

import hashlib
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...model.errors import LingualError
from ...model.surface import RigidSurface
from ...model.tet_mesh import TetMesh
from ...model.tongue_model import TongueModel
from ...model.units import M_PER_MM, MM_PER_M
from ..cache import cached
from ..decimation import decimate
from ..progress import Progress, silent
from ..sensor_placement import sensors_on_midline
from ..skin import skin_of
from ..surfacing import Field, relax, surface_of
from ..tetrahedralise import tetrahedralise
from .anatomy import HeadAnatomy
from .arch import DentalArch, ToothFrame
from .jaw import Jaw
from .palate import UpperJaw
from .teeth import ROOT_DEPTH, crown
from .tongue import Tongue

NODE_COUNTS = {"small": 1800, "medium": 5500, "large": 11000}
SHIPPED = "medium"
ASSET = Path(__file__).with_name("head_medium.npz")
SHAPE_VERSION = 2
"""Raised when the shapes change without a change of HeadAnatomy."""

Arrays = dict[str, NDArray]
Corner = tuple[float, float, float]
Points = NDArray[np.float64]
Surface = tuple[Points, NDArray[np.int32]]

CROWN_TRIANGLES = {"incisor": 350, "canine": 330, "premolar": 370, "molar": 540}

# name: (tissue, frame), in the order in which they are stored
RIGID_PARTS = {
    "mandible": ("bone", "jaw"),
    "lower_gums": ("mucosa", "jaw"),
    "lower_teeth": ("tooth", "jaw"),
    "palate": ("mucosa", "head"),
    "upper_teeth": ("tooth", "head"),
    "hyoid": ("bone", "jaw"),
}


def load_head(size: str = SHIPPED, progress: Progress | None = None) -> TongueModel:
    """The head of our own: "small", "medium" or "large", about 1,800, 5,500 or 11,000 nodes.

    The medium one ships with the package; the others are built when first asked for (tens of seconds)
    and cached. progress: called with a stage and the fraction done.

    Raises LingualError for another size.
    """
    if size not in NODE_COUNTS:
        raise LingualError(f"There is no head of size '{size}': choose {', '.join(NODE_COUNTS)}.")
    report = progress or silent
    shipped = _shipped()
    if shipped is not None and size == SHIPPED:
        return model_of(shipped, f"lingual-{size}")
    key = {**description(), "source": _source_digest()}
    mouth = shipped or cached("head-mouth", key, lambda: build_mouth(progress=report))
    key = {**key, "node_count": NODE_COUNTS[size]}
    tongue = cached(f"head-{size}", key, lambda: build_tongue(NODE_COUNTS[size], progress=report))
    return model_of({**mouth, **tongue}, f"lingual-{size}")


def description(anatomy: HeadAnatomy | None = None) -> dict[str, object]:
    """What the shapes depend on, JSON-serialisable."""
    return {"shape_version": SHAPE_VERSION, "anatomy": (anatomy or HeadAnatomy()).key()}


def description_digest(anatomy: HeadAnatomy | None = None) -> str:
    """SHA-256 of the description; stored in the asset, so that an outdated one is noticed."""
    return hashlib.sha256(json.dumps(description(anatomy), sort_keys=True).encode()).hexdigest()


def _source_digest() -> str:
    """SHA-256 of this folder's code, so that a head built by other code is not taken from the cache."""
    sources = sorted(Path(__file__).parent.glob("*.py"))
    return hashlib.sha256("".join(path.read_text("utf-8") for path in sources).encode()).hexdigest()


def _shipped() -> Arrays | None:
    """The arrays of the asset, or None when it is missing or was made from another description."""
    if not ASSET.exists():
        return None
    with np.load(ASSET, allow_pickle=False) as file:
        arrays = {name: file[name] for name in file.files}
    return arrays if str(arrays.pop("digest", "")) == description_digest() else None


def build_mouth(anatomy: HeadAnatomy | None = None, progress: Progress = silent) -> Arrays:
    """Vertices [m] and triangles of every rigid part, as plain arrays."""
    progress("mouth", 0.0)
    anatomy = anatomy or HeadAnatomy()
    arrays: Arrays = {}
    for name, (vertices, triangles) in rigid_parts(Jaw(anatomy), UpperJaw(anatomy)).items():
        arrays[f"{name}_vertices"] = (vertices * M_PER_MM).astype(np.float32)
        arrays[f"{name}_triangles"] = _compact(triangles)
    progress("mouth", 1.0)
    return arrays


def build_tongue(node_count: int, anatomy: HeadAnatomy | None = None, progress: Progress = silent) -> Arrays:
    """nodes [m], tets and fixed_nodes of a tongue of about `node_count` nodes, as plain arrays."""
    progress("tongue", 0.0)
    anatomy = anatomy or HeadAnatomy()
    tongue = Tongue(anatomy, Jaw(anatomy))
    vertices, triangles = tongue_surface(tongue)
    mesh = tetrahedralise(
        vertices * M_PER_MM,
        triangles,
        node_count,
        progress=lambda stage, done: progress(stage, 0.2 + 0.8 * done),
        name="tongue",
    )
    nodes = mesh.nodes.astype(np.float32)
    return {
        "nodes": nodes,
        "tets": _compact(mesh.tets),
        "fixed_nodes": _compact(np.flatnonzero(tongue.attached(nodes.astype(np.float64) * MM_PER_M))),
    }


def tongue_surface(tongue: Tongue, spacing: float = 1.2) -> Surface:
    """Surface of the tongue, mm."""
    return surface_of(tongue.body, (-80.0, -34.0, -54.0), (0.0, 34.0, 22.0), spacing)


def rigid_parts(jaw: Jaw, upper: UpperJaw) -> dict[str, Surface]:
    """Surfaces of all rigid parts, mm, in the order of RIGID_PARTS."""
    return {
        "mandible": _part(jaw.bone, (-102.0, -66.0, -60.0), (6.0, 66.0, 48.0), 1.9, 4000),
        "lower_gums": _part(jaw.gums, (-70.0, -45.0, -35.0), (8.0, 45.0, 5.0), 1.1, 3000),
        "lower_teeth": _crowns(jaw.arch, jaw.to_rest),
        "palate": _part(upper.palate, (-84.0, -45.0, -18.0), (12.0, 45.0, 36.0), 1.25, 5600),
        "upper_teeth": _crowns(upper.arch),
        "hyoid": _part(jaw.hyoid, (-105.0, -32.0, -62.0), (-46.0, 32.0, -30.0), 1.1, 800),
    }


def _part(field: Field, lower: Corner, upper: Corner, spacing: float, triangle_count: int) -> Surface:
    """A fine surface of the field, reduced to `triangle_count` and put back on the zero level."""
    vertices, triangles = decimate(*surface_of(field, lower, upper, spacing), triangle_count)
    return relax(field, vertices, triangles, reach=0.2 * spacing, count=2), triangles


def _crowns(arch: DentalArch, place: Callable[[Points], Points] | None = None) -> Surface:
    """The 14 crowns of an arch as one surface, each sampled in its own frame; `place` moves them to rest."""
    vertices: list[NDArray[np.float64]] = []
    triangles: list[NDArray[np.int32]] = []
    count = 0
    for frame in arch.frames:
        v, t = _crown(frame)
        vertices.append(place(v) if place else v)
        triangles.append(t + np.int32(count))
        count += len(v)
    return np.concatenate(vertices), np.concatenate(triangles)


def _crown(frame: ToothFrame) -> Surface:
    tooth = frame.tooth
    across, deep = 0.5 * tooth.width + 2.0, 0.5 * tooth.depth + 2.0

    def field(local: Points) -> Points:
        return crown(frame.to_arch(local), frame)

    lower, upper = (-across, -deep, -ROOT_DEPTH - 2.0), (across, deep, tooth.height + 2.0)
    v, t = _part(field, lower, upper, 0.6, CROWN_TRIANGLES[tooth.kind])
    if np.linalg.det(frame.axes) < 0.0:
        t = t[:, ::-1]
    return frame.to_arch(v), t


def _compact(indices: NDArray[np.integer]) -> NDArray[np.integer]:
    """The indices in 16 bits where they fit."""
    return indices.astype(np.uint16 if indices.max(initial=0) < 2**16 else np.int32)


def model_of(arrays: Arrays, name: str) -> TongueModel:
    """The TongueModel of what `build_mouth` and `build_tongue` returned together."""
    mesh = TetMesh(arrays["nodes"].astype(np.float64), arrays["tets"].astype(np.int32))
    rigid = tuple(
        RigidSurface(
            name=part,
            tissue=tissue,
            frame=frame,
            vertices=arrays[f"{part}_vertices"].astype(np.float64),
            triangles=arrays[f"{part}_triangles"].astype(np.int32),
        )
        for part, (tissue, frame) in RIGID_PARTS.items()
    )
    return TongueModel(
        name=name,
        mesh=mesh,
        fixed_nodes=arrays["fixed_nodes"].astype(np.int64),
        sensors=sensors_on_midline(mesh, midline=0.0),
        skin=skin_of(mesh),
        rigid=rigid,
    )


def write_asset() -> None:
    """Builds the medium head and replaces the file that ships with the package."""

    def report(stage: str, done: float) -> None:
        print(f"{done:4.0%} {stage}", flush=True)

    arrays = build_mouth(progress=report) | build_tongue(NODE_COUNTS[SHIPPED], progress=report)
    np.savez_compressed(ASSET, allow_pickle=False, digest=np.array(description_digest()), **arrays)
    print(f"{ASSET}: {ASSET.stat().st_size / 1e6:.2f} MB")
