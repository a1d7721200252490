"""Volumes through meshio and surfaces: what is read, and that damage neither escapes nor hangs."""

import warnings

import meshio
import numpy as np
import pytest

from lingual.model import LingualError, TetMesh
from lingual.precompute.meshes.files import read_tet_mesh
from lingual.precompute.meshes.raw import checked_mesh
from lingual.precompute.meshes.surfaces import read_surface
from lingual.precompute.meshes.warning import MeshWarning

VOLUMES = {
    "vtk": {"binary": True},
    "vtu": {"binary": True},
    "msh": {"file_format": "gmsh", "binary": True},
    "mesh": {},
    "inp": {},
}
SURFACES = {"stl": {"binary": False}, "ply": {"binary": True}}


@pytest.fixture
def volume_file(tmp_path, wedge):
    def write(suffix: str, cells=None, name: str = "tongue") -> object:
        path = tmp_path / f"{name}.{suffix}"
        meshio.write(path, meshio.Mesh(wedge[0], cells or [("tetra", wedge[1])]), **VOLUMES[suffix])
        return path

    return write


@pytest.fixture
def surface(wedge):
    mesh = TetMesh(*wedge)
    triangles = np.searchsorted(mesh.boundary_nodes, mesh.boundary_triangles)
    return wedge[0][mesh.boundary_nodes], triangles


@pytest.fixture
def surface_file(tmp_path, surface):
    def write(suffix: str) -> object:
        path = tmp_path / f"tongue.{suffix}"
        vertices, triangles = surface
        if suffix == "obj":
            lines = [f"v {x!r} {y!r} {z!r}" for x, y, z in vertices.tolist()]
            lines += [f"f {a}//{a} {b} {c}/{c}" for a, b, c in (triangles + 1).tolist()]
            path.write_text("\n".join(["# surface", "o tongue", *lines, ""]))
        else:
            meshio.write(path, meshio.Mesh(vertices, [("triangle", triangles)]), **SURFACES[suffix])
        return path

    return write


@pytest.mark.parametrize("suffix", VOLUMES)
def test_volumes_come_back(volume_file, wedge, suffix, capsys):
    raw = read_tet_mesh(volume_file(suffix))
    capsys.readouterr()
    np.testing.assert_allclose(raw.nodes, wedge[0], atol=1e-9)
    np.testing.assert_array_equal(raw.tets, wedge[1])


def test_triangles_beside_tetrahedra_are_ignored(volume_file, wedge):
    faces = TetMesh(*wedge).boundary_triangles
    raw = read_tet_mesh(volume_file("vtu", [("triangle", faces), ("tetra", wedge[1])]))
    np.testing.assert_array_equal(raw.tets, wedge[1])


@pytest.mark.parametrize("kind", ["triangle", "hexahedron", "mixed"])
def test_what_is_not_made_of_tetrahedra_is_refused(volume_file, wedge, kind):
    cells = {
        "triangle": [("triangle", np.array([[0, 1, 2]]))],
        "hexahedron": [("hexahedron", np.arange(8)[None])],
        "mixed": [("tetra", wedge[1]), ("wedge", np.arange(6)[None])],
    }[kind]
    with pytest.raises(LingualError, match="must be made of tetrahedra, but it holds"):
        read_tet_mesh(volume_file("vtu", cells))


@pytest.mark.parametrize("suffix", VOLUMES)
def test_truncated_volumes_are_refused_and_nothing_is_printed(volume_file, wedge, suffix, capsys):
    path = volume_file(suffix)
    capsys.readouterr()
    content = path.read_bytes()
    for length in range(0, len(content) - 40, len(content) // 25):
        path.write_bytes(content[:length])
        message = refusal(path)
        # Abaqus' lists have no count: cut between two lines they are just shorter.
        assert suffix == "inp" or message is not None, length
        assert message is None or ("tongue" in message and "\n" not in message)
    assert capsys.readouterr() == ("", "")


def refusal(path) -> str | None:
    """The message with which a mesh is refused, None when it is not."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MeshWarning)
        try:
            raw = read_tet_mesh(path)
            checked_mesh(raw, raw.nodes)
        except LingualError as error:
            return str(error)
    return None


def test_unreadable_volumes(tmp_path):
    (tmp_path / "noise.vtk").write_bytes(np.random.default_rng(0).bytes(5000))
    (tmp_path / "empty.msh").write_bytes(b"")
    (tmp_path / "scan.dcm").write_bytes(b"DICM")
    (tmp_path / "folder.vtk").mkdir()
    for name, message in {
        "noise.vtk": "cannot be read as a mesh",
        "empty.msh": "is empty",
        "absent.vtu": "There is no file",
        "scan.dcm": "'.dcm' is not known as a tetrahedral mesh",
        "folder.vtk": "is a directory",
    }.items():
        with pytest.raises(LingualError, match=message):
            read_tet_mesh(tmp_path / name)


@pytest.mark.parametrize("suffix", ["obj", "stl", "ply"])
def test_surfaces_come_back(surface_file, surface, suffix):
    vertices, triangles = read_surface(surface_file(suffix))
    np.testing.assert_allclose(vertices[triangles], surface[0][surface[1]], rtol=1e-6, atol=1e-6)


def test_samples_of_obj(shared_data):
    for name, counts in {"badinjaw": (2094, 4184), "palate1": (569, 1029)}.items():
        vertices, triangles = read_surface(shared_data / f"artisynth/tongue3d/{name}.obj")
        assert (len(vertices), len(triangles)) == counts


def test_polygons_and_negative_numbers_of_obj(tmp_path):
    path = tmp_path / "square.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf -4 -3 -2\nvt 0 0\n")
    _, triangles = read_surface(path)
    assert triangles.tolist() == [[0, 1, 2], [0, 2, 3], [0, 1, 2]]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("v 0 0\n", "line 1: a vertex needs three"),
        ("v 0 0 0\nf 1 1\n", "line 2: a face needs three"),
        ("v 0 0 0\nf 0 1 1\n", "line 2: a face names vertex 0"),
        ("v 0 0 0\nf -2 1 1\n", "line 2: a face names vertex -2"),
        ("v 0 0 0\nf 1 1 2\n", "a face names vertex 1, but the vertices are 0 to 0"),
        ("v 0 0 a\n", "line 1: 'a' is not a number"),
        ("v 0 0 0\nf 1 b 1\n", "line 2: 'b' is not a whole number"),
        ("v 0 0 nan\nf 1 1 1\n", "vertex 0 has a coordinate that is not"),
        ("v 0 0 0\n", "has no faces"),
        ("v 0 0 0\nf 1 1 1", "line 2: the last line is not ended"),
    ],
)
def test_damaged_obj(tmp_path, text, message):
    path = tmp_path / "surface.obj"
    path.write_text(text)
    with pytest.raises(LingualError, match=message):
        read_surface(path)


@pytest.mark.parametrize("suffix", ["stl", "ply"])
def test_truncated_surfaces_are_refused_without_hanging(surface_file, suffix):
    path = surface_file(suffix)
    content = path.read_bytes()
    for length in [*range(0, 400, 40), *range(400, len(content) - 20, len(content) // 20)]:
        path.write_bytes(content[:length])
        with pytest.raises(LingualError, match="tongue"):
            read_surface(path)


def test_a_surface_of_another_kind(tmp_path):
    with pytest.raises(LingualError, match=r"must end in \.obj, \.stl, \.ply"):
        read_surface(tmp_path / "jaw.fbx")
