"""Tongues by name and path: the published meshes, a user's own, and what is assumed about them."""

import re
import warnings
from pathlib import Path

import numpy as np
import pytest

from lingual.model import LingualError
from lingual.precompute.meshes import library
from lingual.precompute.meshes.description import read_sidecar
from lingual.precompute.meshes.frame import MeshFrame, axis_matrix, guessed_unit, parse_unit
from lingual.precompute.meshes.library import describe, load_tongue, mesh_path
from lingual.precompute.meshes.tetgen import read_nodes
from lingual.precompute.meshes.warning import MeshWarning
from lingual.speech import fit_to_sensors, load_trajectory


@pytest.fixture(scope="module")
def luo(shared_data):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return load_tongue(shared_data / "luo_tongue")


def test_luos_tongue_is_in_the_head_frame_in_metres(luo):
    extent = np.ptp(luo.mesh.nodes, axis=0)
    np.testing.assert_allclose(extent, [66.443e-3, 57.2365e-3, 60.5905e-3], atol=1e-6)
    assert luo.mesh.volume == pytest.approx(110.0e-6, rel=1e-3)
    tip = luo.mesh.nodes[np.argmax(luo.mesh.nodes[:, 0])]
    assert abs(tip[1]) < 2e-3  # the most anterior node lies on the midline


def test_luos_fixed_nodes_are_the_base_and_the_chin(luo):
    assert len(luo.fixed_nodes) == 1251  # 3753 degrees of freedom
    height = luo.mesh.nodes[:, 2] - luo.mesh.nodes[:, 2].min()
    assert height[luo.fixed_nodes].max() < 0.38 * height.max()
    assert np.isin(np.argsort(height)[:500], luo.fixed_nodes).all()


def test_luos_sensors_sit_where_his_coils_were(luo, shared_data):
    raw = np.loadtxt(shared_data / "ema/luo/20150624_0_041_sync.txt", skiprows=1, max_rows=1)
    recorded = {name: -raw[1 + 2 * i : 3 + 2 * i] * 1e-3 for i, name in enumerate(("TR", "TD", "TB", "TT"))}
    for name, position in zip(luo.sensors.names, luo.sensor_rest_positions, strict=True):
        assert np.linalg.norm(position[[0, 2]] - recorded[name]) < 4e-3
        assert abs(position[1]) < 1e-4
    assert luo.sensors.names == ("TT", "TB", "TD", "TR")


def test_luos_sentence_moves_luos_tongue(luo, shared_data):
    trajectory = load_trajectory(shared_data / "ema/luo/20150624_0_041_sync.txt")
    targets = fit_to_sensors(trajectory, luo)
    assert targets.frame_count == 752
    displacement = np.linalg.norm(targets.positions - luo.sensor_rest_positions, axis=2)
    assert not displacement[0].any()
    assert displacement.max() == pytest.approx(17.0e-3, abs=0.1e-3)


@pytest.mark.parametrize(("stem", "fixed_count"), [("tongue3.1", 156), ("tongue.1", 268)])
def test_artisynths_tongues(shared_data, stem, fixed_count):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        model = load_tongue(shared_data / "artisynth/tongue3d" / stem)
    nodes = model.mesh.nodes
    assert model.mesh.volume == pytest.approx(96.5e-6, rel=0.01)
    assert len(model.fixed_nodes) == fixed_count
    fixed = nodes[model.fixed_nodes]
    assert fixed[:, 2].mean() < np.quantile(nodes[:, 2], 0.35)  # up is up
    # Hyoid and chin, and both sides.
    assert np.ptp(fixed[:, 0]) > 0.045
    assert fixed[:, 1].min() == pytest.approx(-fixed[:, 1].max(), abs=1e-3)
    parts = {part.name: part for part in model.rigid}
    assert set(parts) == {"mandible", "hyoid", "maxilla", "palate"}
    assert parts["mandible"].frame == "jaw"
    assert parts["palate"].frame == "head"
    # The origin is the upper incisors' edge, and the tongue lies under the palate and behind the teeth.
    edge = parts["maxilla"].vertices
    assert np.linalg.norm(edge, axis=1).min() < 4e-3
    assert -0.012 < nodes[:, 0].max() < 0.0
    near = np.abs(parts["palate"].vertices[:, 1]) < 2e-3
    hard = near & (parts["palate"].vertices[:, 0] > -0.05)
    assert parts["palate"].vertices[hard, 2].max() > nodes[np.abs(nodes[:, 1]) < 2e-3, 2].max()


def test_artisynths_lists_are_numbered_from_0(shared_data):
    """From 0 both attachments are compact and symmetric; from 1 a hyoid node lies in the tongue's tip."""
    folder = shared_data / "artisynth/tongue3d"
    _, points = read_nodes(folder / "tongue.node")
    hyoid = np.array((folder / "hyoidAttachments.txt").read_text().split(), dtype=int)
    assert np.ptp(points[hyoid, 2]) < 0.012
    assert np.ptp(points[hyoid - 1, 2]) > 0.04


def test_a_folder_with_two_known_meshes_says_which_is_used(shared_data):
    with pytest.warns(MeshWarning, match=r"tongue3\.1 and tongue\.1; tongue3\.1 is used"):
        assert mesh_path(shared_data / "artisynth/tongue3d").name == "tongue3.1.ele"


def test_a_known_name_with_other_counts_is_another_mesh(wedge, write_tetgen):
    assert describe(write_tetgen(*wedge, name="tongue.1")).unit is None


def loaded(path, **options):
    """The model and all warnings as one text."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        model = load_tongue(path, **options)
    assert all(issubclass(w.category, MeshWarning) for w in caught)
    return model, " ".join(str(w.message) for w in caught)


@pytest.mark.parametrize("scale", [1e-3, 0.1, 1.0])
def test_a_mesh_of_ones_own_has_unit_and_attachment_assumed_aloud(wedge, write_tetgen, scale):
    nodes, tets = wedge
    model, said = loaded(write_tetgen(nodes * scale, tets))
    np.testing.assert_allclose(model.mesh.nodes, nodes * 1e-3, atol=1e-9)
    assert f"{ {1e-3: 'm', 0.1: 'cm', 1.0: 'mm'}[scale] } is assumed: it is 80 mm long" in said
    assert f"so the {len(model.fixed_nodes)} at the base and behind the chin are held" in said
    assert model.sensors.names == ("TT", "TB", "TD", "TR")
    x = model.sensor_rest_positions[:, 0]
    assert (np.diff(x) < 0).all()


def test_the_units_option(wedge, write_tetgen):
    nodes, tets = wedge
    path = write_tetgen(nodes * 2.0, tets)
    model, said = loaded(path, units="0.0005")
    np.testing.assert_allclose(model.mesh.nodes, nodes * 1e-3, atol=1e-9)
    assert "unit is not given" not in said
    with pytest.raises(LingualError, match="160 units long, which is no tongue in m, cm or mm"):
        load_tongue(path)
    with pytest.raises(LingualError, match="The unit 'inch' is not known"):
        load_tongue(path, units="inch")


SIDECAR = """
unit = "mm"
axes = "-x -y +z"
origin = [1.0, 2.0, 3.0]
[fixed]
numbers = [1, 2, 3, 4, 5]
[sensors.points]
TT = [12.0, 2.0, -5.0]
TB = [30.0, 2.0, 0.0]
[[rigid]]
name = "palate"
file = "palate.obj"
tissue = "mucosa"
frame = "head"
unit = 0.01
"""


def test_a_sidecar_says_everything(wedge, write_tetgen, tmp_path):
    nodes, tets = wedge
    turned = nodes * [-1.0, -1.0, 1.0] + [1.0, 2.0, 3.0]
    path = write_tetgen(turned, tets, first=1)
    (tmp_path / "tongue.lingual.toml").write_text(SIDECAR)
    (tmp_path / "palate.obj").write_text("v 0 0 1\nv 1 0 1\nv 0 1 1\nf 1 2 3\n")
    model, said = loaded(path)
    assert not said
    np.testing.assert_allclose(model.mesh.nodes, nodes * 1e-3, atol=1e-9)
    np.testing.assert_array_equal(model.fixed_nodes, [0, 1, 2, 3, 4])
    assert model.sensors.names == ("TT", "TB")
    np.testing.assert_allclose(model.sensor_rest_positions[0, :2], [-0.011, 0.0], atol=1.5e-3)
    (palate,) = model.rigid
    assert (palate.name, palate.tissue, palate.frame) == ("palate", "mucosa", "head")
    np.testing.assert_allclose(palate.vertices[1], [0.01, 0.0, 0.01])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("unit = ", "is not valid TOML"),
        ('unit = "inch"', "The unit 'inch' is not known"),
        ("unit = -1", "The unit '-1' is not known"),
        ('axes = "x y z"', "The axes of a mesh are 'x y z'"),
        ('axes = "+x +y -z"', "would mirror it"),
        ("origin = [1, 2]", "'origin' must be three numbers"),
        ("colour = 1", "'colour' is not known here"),
        ("fixed = 3", "'fixed' must be a table"),
        ("[fixed]\nwithin_mm = 3", "'fixed' must have 'files', 'numbers' or 'points'"),
        ("[fixed]\nnumbers = [1, 2, 9999]", "9999 is no node of the mesh; it has 270 nodes, numbered from 0"),
        ("[fixed]\nnumbers = [1, 2]", "it fixes 2 nodes of the mesh; at least 3"),
        ('[fixed]\nfiles = ["absent.txt"]', "There is no file .*absent.txt"),
        ('[fixed]\nfiles = ["words.txt"]', "words.txt, line 2: 'three' is not a whole number"),
        (
            '[fixed]\nformat = "dofs"\nfiles = ["dofs.txt"]',
            "dofs.txt: 9 numbers are announced",
        ),
        ("[fixed]\npoints = [[0, 0, 900]]", "it fixes 0 nodes"),
        ('[fixed]\nformat = "numbers-in"\nnumbers = [1]', "'fixed.numbers_in' must name the node file"),
        ("[sensors]\n", "'sensors' must have either 'points' or 'arc_lengths_mm'"),
        ('[sensors.points]\nTT = "here"', "'sensors.points.TT' must be three numbers"),
        ("[sensors.points]\nTT = [-0.02, 0.0, -0.01]\nTB = [0, 0, 99]", "the sensor TB is placed"),
        ("[sensors.arc_lengths_mm]\nTT = 500.0", "tongue.ele: The tongue's upper surface is"),
        ('[[rigid]]\nname = "jaw"', "'rigid.file' is missing"),
    ],
)
@pytest.mark.filterwarnings("ignore::lingual.precompute.meshes.warning.MeshWarning")
def test_a_wrong_sidecar_is_refused_by_key(wedge, write_tetgen, tmp_path, text, message):
    (tmp_path / "words.txt").write_text("1 2\nthree\n")
    (tmp_path / "dofs.txt").write_text("9\n0\n1\n2\n")
    (tmp_path / "tongue.lingual.toml").write_text(text)
    with pytest.raises(LingualError, match=message) as error:
        load_tongue(write_tetgen(*wedge))
    assert "\n" not in str(error.value)


def test_the_documents_example_is_a_sidecar(tmp_path):
    document = Path(__file__).parents[3] / "docs" / "formats.md"
    (example,) = re.findall(r"```toml\n(.*?)```", document.read_text(), re.DOTALL)
    path = tmp_path / "tongue.lingual.toml"
    path.write_text(example)
    description = read_sidecar(path, "tongue")
    assert description.unit == 0.001
    assert description.sensors is not None
    assert tuple(description.sensors.points or ()) == ("TT", "TB", "TD", "TR")
    assert [part.name for part in description.rigid] == ["mandible"]


def test_a_loose_piece_is_refused(wedge, write_tetgen):
    nodes, tets = wedge
    island = np.array([[0.0, 0, 30], [1, 0, 30], [0, 1, 30], [0, 0, 31]])
    path = write_tetgen(np.vstack([nodes, island]), np.vstack([tets, [[270, 271, 272, 273]]]))
    with (
        pytest.warns(MeshWarning),
        pytest.raises(LingualError, match="falls into 2 pieces, and one of 4 nodes has no fixed node"),
    ):
        load_tongue(path)


def test_paths_that_name_no_single_mesh(tmp_path, wedge, write_tetgen):
    with pytest.raises(LingualError, match="There is no mesh 'nonesuch': give head, head-small"):
        load_tongue("nonesuch")
    with pytest.raises(LingualError, match="There is no mesh in"):
        load_tongue(tmp_path)
    for name in ("a", "b"):
        write_tetgen(*wedge, name=name)
    with pytest.raises(LingualError, match=r"holds 2 meshes \(a\.ele, b\.ele\): name one"):
        load_tongue(tmp_path)
    with pytest.raises(LingualError, match="cannot be read"):
        load_tongue("x" * 5000)
    assert mesh_path(tmp_path / "a").name == "a.node"


def test_axes_units_and_frames():
    np.testing.assert_array_equal(axis_matrix("-x +z +y") @ [1.0, 2.0, 3.0], [-1.0, 3.0, 2.0])
    frame = MeshFrame(0.0005, "-x +z +y", (10.0, 0.0, 0.0))
    np.testing.assert_allclose(frame.to_head(np.array([[12.0, -4.0, 6.0]])), [[-0.001, 0.003, -0.002]])
    assert [parse_unit(u) for u in ("mm", "CM", 1, "0.0005")] == [0.001, 0.01, 1.0, 0.0005]
    for wrong in ("", "0", "nan", "-1", "inf"):
        with pytest.raises(LingualError, match="is not known; give m, cm, mm"):
            parse_unit(wrong)
    with pytest.warns(MeshWarning, match="mm is assumed"):
        assert guessed_unit(np.array([[0.0, 0, 0], [70.0, 10, 10]]), "x") == 0.001


def test_a_users_closed_surface_is_filled(tmp_path, wedge, monkeypatch):
    from lingual.model import TetMesh

    monkeypatch.setenv("LINGUAL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(library, "SURFACE_NODE_COUNT", 500)
    monkeypatch.chdir(tmp_path)
    mesh = TetMesh(*wedge)
    path = tmp_path / "tongue.obj"
    lines = [f"v {x} {y} {z}" for x, y, z in wedge[0].tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (mesh.boundary_triangles + 1).tolist()]
    path.write_text("\n".join(lines) + "\n")
    stages = []
    with pytest.warns(MeshWarning):
        model = load_tongue(path, progress=lambda stage, fraction: stages.append(fraction))
    assert model.mesh.volume == pytest.approx(mesh.volume * 1e-9, rel=0.05)
    assert stages
    with pytest.warns(MeshWarning):
        again = load_tongue(path)
    np.testing.assert_array_equal(again.mesh.nodes, model.mesh.nodes)
    lines.pop()
    path.write_text("\n".join(lines) + "\n")
    with (
        pytest.warns(MeshWarning),
        pytest.raises(LingualError, match=r"tongue\.obj.* is not closed: 3 of its edges"),
    ):
        load_tongue(path)
