"""The head that ships: what its description says, anatomically plausible, and nothing in anything else."""

import numpy as np
import pytest

from lingual.model import LingualError, TongueModel
from lingual.precompute.head import load_head
from lingual.precompute.head.anatomy import HeadAnatomy
from lingual.precompute.head.build import (
    ASSET,
    NODE_COUNTS,
    build_tongue,
    description_digest,
)
from lingual.precompute.head.jaw import Jaw
from lingual.precompute.head.palate import UpperJaw
from lingual.precompute.head.teeth import crown
from lingual.precompute.head.tongue import Tongue
from lingual.precompute.sensor_placement import upper_midline
from lingual.precompute.tetrahedralise import enclosed_volume

ANATOMY = HeadAnatomy()
JAW, UPPER = Jaw(ANATOMY), UpperJaw(ANATOMY)


@pytest.fixture(scope="module")
def head() -> TongueModel:
    return load_head()


def dihedral_angles(mesh) -> np.ndarray:
    """All six of every tetrahedron [degrees], (tet_count, 6)."""
    normals = mesh.shape_gradients / np.linalg.norm(mesh.shape_gradients, axis=2, keepdims=True)
    cosines = np.einsum("eia,eja->eij", normals, normals)[:, *np.triu_indices(4, 1)]
    return np.degrees(np.arccos(np.clip(-cosines, -1.0, 1.0)))


def test_asset_was_made_from_the_present_description():
    with np.load(ASSET, allow_pickle=False) as file:
        assert str(file["digest"]) == description_digest(), "run python -m lingual.precompute.head"
    assert ASSET.stat().st_size < 1.5e6


def test_asset_lies_on_the_present_shapes(head):
    """What the digest cannot see: a change of the code that draws the shapes."""
    fields = {
        "mandible": JAW.bone,
        "lower_gums": JAW.gums,
        "lower_teeth": JAW.teeth,
        "palate": UPPER.palate,
        "upper_teeth": UPPER.teeth,
        "hyoid": JAW.hyoid,
    }
    for part in head.rigid:
        distance = np.abs(fields[part.name](part.vertices[::5] * 1e3))
        assert np.quantile(distance, 0.95) < 0.05, f"{part.name}: run python -m lingual.precompute.head"
    boundary = head.mesh.nodes[head.mesh.boundary_nodes] * 1e3
    assert np.abs(Tongue(ANATOMY, JAW).body(boundary)).max() < 0.35, "run python -m lingual.precompute.head"


def test_mesh_size_and_quality(head):
    assert head.mesh.node_count == pytest.approx(NODE_COUNTS["medium"], rel=0.15)
    angles = dihedral_angles(head.mesh)
    assert angles.min() > 8.0
    assert angles.max() < 165.0
    assert np.median(head.mesh.volumes) / head.mesh.volumes.min() < 200.0


def test_tongue_has_human_dimensions(head):
    nodes = head.mesh.nodes * 1e3
    assert 65.0 < head.mesh.volume * 1e6 < 110.0
    assert 40.0 < np.ptp(nodes[:, 1]) < 55.0
    line = upper_midline(head.mesh, midline=0.0) * 1e3
    assert 85.0 < np.linalg.norm(np.diff(line, axis=0), axis=1).sum() < 100.0
    top = line[np.argmax(line[:, 2])]
    assert -50.0 < top[0] < -32.0  # the dorsum is the highest part
    assert abs(nodes[:, 1].max() + nodes[:, 1].min()) < 0.5


def test_midline_is_a_groove(head):
    """The dorsum is lower on the midline than 5 mm beside it."""
    surface = head.skin.vertices(head.mesh.nodes) * 1e3
    dorsum = surface[(surface[:, 2] > 0.0) & (surface[:, 0] > -45.0) & (surface[:, 0] < -25.0)]
    for x in (-42.0, -35.0, -28.0):
        near = dorsum[np.abs(dorsum[:, 0] - x) < 2.0]
        middle = near[np.abs(near[:, 1]) < 1.0, 2].max()
        beside = near[np.abs(np.abs(near[:, 1]) - 6.0) < 1.5, 2].max()
        assert 0.3 < beside - middle < 3.0


def test_sensors_lie_on_the_midline_at_their_distances(head):
    at = head.sensor_rest_positions
    assert np.abs(at[:, 1]).max() < 0.5e-3
    line = upper_midline(head.mesh, midline=0.0)
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(line, axis=0), axis=1))])
    fine = np.linspace(0.0, length[-1], 5000)
    dense = np.stack([np.interp(fine, length, line[:, a]) for a in range(3)], axis=1)
    found = [fine[np.argmin(np.linalg.norm(dense - p, axis=1))] * 1e3 for p in at]
    assert found == pytest.approx([10.0, 30.0, 45.0, 60.0], abs=0.5)


def test_bone_holds_the_lower_part_only(head):
    nodes = head.mesh.nodes * 1e3
    fixed = nodes[head.fixed_nodes]
    assert 0.03 < len(fixed) / len(nodes) < 0.30
    assert fixed[:, 2].max() < -20.0
    genial = np.linalg.norm(fixed - JAW.genial_tubercle, axis=1) < 9.0
    assert genial.sum() >= 10
    assert (JAW.hyoid(fixed) < 5.5).sum() >= 10
    assert not np.isin(head.sensors.weights.indices, head.fixed_nodes).any()


def test_nothing_penetrates(head):
    surface = head.mesh.nodes[head.mesh.boundary_nodes] * 1e3
    for field in (JAW.bone, JAW.gums, JAW.teeth, JAW.hyoid):
        assert field(surface).min() > -0.5
    assert UPPER.palate(surface).min() > 0.5
    assert UPPER.teeth(surface).min() > 0.5
    skin = head.skin.vertices(head.mesh.nodes) * 1e3
    assert JAW.teeth(skin).min() > -0.3
    assert UPPER.teeth(skin).min() > 0.5


def test_rigid_parts(head):
    parts = {part.name: part for part in head.rigid}
    assert {"mandible", "lower_teeth", "palate", "upper_teeth", "hyoid"} <= set(parts)
    assert sum(len(part.triangles) for part in head.rigid) <= 40_000
    for part in head.rigid:
        edges = np.sort(part.triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        assert (np.unique(edges, axis=0, return_counts=True)[1] % 2 == 0).all(), part.name
        assert enclosed_volume(part.vertices, part.triangles) > 0.0, part.name
        assert part.frame == ("head" if part.name in ("palate", "upper_teeth") else "jaw")
    upper, lower = (parts[f"{side}_teeth"].vertices * 1e3 for side in ("upper", "lower"))
    front = np.abs(upper[:, 1]) < 4.0
    assert upper[front, 2].min() == pytest.approx(0.0, abs=0.6)  # the origin is the incisors' edge
    gap = upper[front, 2].min() - lower[np.abs(lower[:, 1]) < 4.0, 2].max()
    assert 2.0 < gap < 8.0


def test_rest_opening_turns_about_the_condyles():
    edge = np.array([[JAW.arch.knots[0][0], 0.0, ANATOMY.overbite]])
    rest = JAW.to_rest(edge)
    assert np.linalg.norm(rest - edge) == pytest.approx(ANATOMY.rest_opening, rel=0.02)
    assert np.allclose(JAW.to_bite(rest), edge)
    condyle = np.array([ANATOMY.condyle])
    assert np.allclose(JAW.to_rest(condyle), condyle)


def test_crowns_have_the_cited_heights_and_widths():
    for arch in (JAW.arch, UPPER.arch):
        for frame in arch.frames:
            tooth = frame.tooth
            probes = {  # crown's frame [mm]: inside?
                (0.42 * tooth.width, 0.0, 0.6 * tooth.height): True,
                (-0.42 * tooth.width, 0.0, 0.6 * tooth.height): True,
                (0.56 * tooth.width, 0.0, 0.6 * tooth.height): False,
                (-0.56 * tooth.width, 0.0, 0.6 * tooth.height): False,
                (0.0, 0.0, 0.2 * tooth.height): True,
                (0.0, 0.56 * tooth.depth, 0.2 * tooth.height): False,
                (0.0, -0.56 * tooth.depth, 0.2 * tooth.height): False,
                (0.0, 0.0, tooth.height + 0.5): False,
            }
            distance = crown(frame.to_arch(np.array(list(probes))), frame)
            assert [d < 0.0 for d in distance] == list(probes.values()), tooth


def test_unknown_size_is_named():
    with pytest.raises(LingualError, match="no head of size 'huge'"):
        load_head("huge")


@pytest.mark.slow
def test_small_tongue_from_nothing():
    arrays = build_tongue(NODE_COUNTS["small"])
    nodes = arrays["nodes"].astype(float) * 1e3
    assert len(nodes) == pytest.approx(NODE_COUNTS["small"], rel=0.15)
    assert Tongue(ANATOMY, JAW).attached(nodes).sum() == len(arrays["fixed_nodes"])
