"""TetGen pairs: values read off the samples, both numberings, and every way a pair can be wrong."""

import warnings

import numpy as np
import pytest

from lingual.model import LingualError, TetMesh
from lingual.precompute.meshes.files import read_tet_mesh
from lingual.precompute.meshes.raw import checked_mesh
from lingual.precompute.meshes.tetgen import read_nodes
from lingual.precompute.meshes.warning import MeshWarning

SAMPLES = {
    "luo_tongue/tongue_tuned_v3.1": (5452, 21051),
    "artisynth/tongue3d/tongue3.1": (1803, 8606),
    "artisynth/tongue3d/tongue.1": (2228, 11098),
}


@pytest.mark.parametrize("stem", SAMPLES)
def test_samples_have_their_announced_counts_and_positive_elements(shared_data, stem):
    raw = read_tet_mesh(shared_data / f"{stem}.ele")
    assert (len(raw.nodes), len(raw.tets)) == SAMPLES[stem]
    mesh, kept = checked_mesh(raw, raw.nodes)
    assert (mesh.volumes > 0).all()
    np.testing.assert_array_equal(kept, np.arange(len(raw.nodes)))


def test_values_of_luos_mesh(shared_data):
    raw = read_tet_mesh(shared_data / "luo_tongue/tongue_tuned_v3.1.node")
    np.testing.assert_array_equal(
        raw.nodes[1], [92.958200000000005, -252.04900000000001, -3.9353800000000003e-5]
    )
    np.testing.assert_array_equal(raw.tets[2], [1731, 2390, 2389, 4653])


def test_points_without_a_line_of_counts(shared_data):
    first, points = read_nodes(shared_data / "artisynth/tongue3d/tongue.node")
    assert first == 1
    assert points.shape == (946, 3)
    np.testing.assert_array_equal(points[-1], [0.08122471, 0.0, 0.08010003])


@pytest.mark.parametrize("first", [0, 1])
def test_numbers_from_0_and_from_1(wedge, write_tetgen, first):
    path = write_tetgen(*wedge, first=first)
    for named in (path, path.with_suffix(".node")):
        raw = read_tet_mesh(named)
        np.testing.assert_array_equal(raw.nodes, wedge[0])
        np.testing.assert_array_equal(raw.tets, wedge[1])
        assert (raw.first_node, raw.first_element) == (first, first)


def test_attributes_markers_and_comments(tmp_path):
    (tmp_path / "one.node").write_text(
        "# one element\n4 3 1 1\n1 0 0 0 9.5 0\n2 1 0 0 9.5 1 # here\n\n3 0 1 0 9.5 0\n4 0 0 1 9.5 0\n"
    )
    (tmp_path / "one.ele").write_text("1 4 1\n1 1 2 3 4 7\n")
    raw = read_tet_mesh(tmp_path / "one.ele")
    assert raw.tets.tolist() == [[0, 1, 2, 3]]
    assert raw.nodes[1].tolist() == [1.0, 0.0, 0.0]


def test_second_order_elements_keep_their_corners(tmp_path):
    nodes = np.vstack([np.zeros(3), np.eye(3), np.full((6, 3), 0.5)])
    (tmp_path / "q.node").write_text(
        "10 3 0 0\n" + "".join(f"{i} {x} {y} {z}\n" for i, (x, y, z) in enumerate(nodes.tolist()))
    )
    (tmp_path / "q.ele").write_text("1 10 0\n0 0 1 2 3 4 5 6 7 8 9\n")
    raw = read_tet_mesh(tmp_path / "q.ele")
    with pytest.warns(MeshWarning, match="6 nodes belong to no element and are left out"):
        mesh, kept = checked_mesh(raw, raw.nodes)
    assert mesh.node_count == 4
    assert kept.tolist() == [0, 1, 2, 3]


def edited(path, line: int, text: str) -> None:
    lines = path.read_text().splitlines(keepends=True)
    lines[line - 1] = text
    path.write_text("".join(lines))


@pytest.mark.parametrize(
    ("suffix", "line", "text", "message"),
    [
        (
            ".node",
            1,
            "271 3 0 0\n",
            r"tongue.node, line 271: the file ends after 270 points, .* 271",
        ),
        (".node", 1, "269 3 0 0\n", r"tongue.node, line 271: there are more than the 269 points"),
        (".node", 1, "270 2 0 0\n", r"tongue.node, line 1: the points have dimension 2"),
        (".node", 1, "270 3 0 1\n", r"tongue.node, line 2: 4 values where 5 are needed"),
        (".node", 2, "5 0 0 0\n", r"tongue.node, line 2: numbers start at 5; they must start at 0 or 1"),
        (".node", 9, "8 0 0 0\n", r"tongue.node, line 9: number 8 stands where 7 is due"),
        (".node", 9, "7 0 0\n", r"tongue.node, line 9: 3 values where 4 are needed"),
        (".node", 9, "7 0 0 x\n", r"tongue.node, line 9: 'x' is not a number"),
        (".node", 9, "7 0 0 nan\n", r"tongue.node, line 9: a coordinate is not finite"),
        (".ele", 1, "961 4 0\n", r"tongue.ele, line 961: the file ends after 960 elements, .* 961"),
        (".ele", 1, "0 4 0\n", r"tongue.ele has no elements"),
        (".ele", 1, "960 8 0\n", r"tongue.ele, line 1: the elements have 8 points each"),
        (".ele", 1, "many 4 0\n", r"tongue.ele, line 1: 'many' is not a whole number"),
        (".ele", 5, "3 1 2 3\n", r"tongue.ele, line 5: 4 values where 5 are needed"),
        (".ele", 5, "3 1 2 3 4.5\n", r"tongue.ele, line 5: '4.5' is not a whole number"),
        (".ele", 5, "3 1 2 3 4\0\n", r"tongue.ele, line 5: this is not text"),
    ],
)
def test_a_damaged_line_is_named(wedge, write_tetgen, suffix, line, text, message):
    path = write_tetgen(*wedge)
    edited(path.with_suffix(suffix), line, text)
    with pytest.raises(LingualError, match=message) as error:
        read_tet_mesh(path)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize("suffix", [".node", ".ele"])
def test_every_truncation_is_refused_or_whole(wedge, write_tetgen, suffix):
    path = write_tetgen(*wedge)
    damaged = path.with_suffix(suffix)
    content = damaged.read_bytes()
    whole = content.index(b"# a comment")
    for length in [*range(0, whole, 997), *range(whole - 30, whole)]:
        damaged.write_bytes(content[:length])
        with pytest.raises(LingualError, match=rf"tongue\{suffix}"):
            read_tet_mesh(path)
    damaged.write_bytes(content[:whole])
    assert len(read_tet_mesh(path).tets) == len(wedge[1])


def test_a_missing_half_is_named(wedge, write_tetgen):
    path = write_tetgen(*wedge)
    path.with_suffix(".node").unlink()
    with pytest.raises(LingualError, match=r"no file .*tongue\.node, which tongue\.ele needs"):
        read_tet_mesh(path)
    with pytest.raises(LingualError, match=r"There is no file .*absent\.ele"):
        read_tet_mesh(path.with_name("absent.ele"))


@pytest.mark.parametrize("first", [0, 1])
def test_bad_elements_are_named_by_the_files_own_number(wedge, write_tetgen, first):
    nodes, tets = wedge
    number = 17 + first

    def refused(changed: np.ndarray, message: str) -> None:
        raw = read_tet_mesh(write_tetgen(nodes, changed, first=first))
        with pytest.raises(LingualError, match=message):
            checked_mesh(raw, raw.nodes * 1e-3)

    inverted, repeated, flat, outside = (tets.copy() for _ in range(4))
    inverted[17] = inverted[17][[1, 0, 2, 3]]
    repeated[17] = repeated[3][[1, 2, 0, 3]]
    flat[17, 1] = flat[17, 0]
    outside[17, 2] = len(nodes)
    refused(inverted, rf"tongue.ele: element {number} is inverted \(signed volume -\d+")
    refused(repeated, rf"tongue.ele: element {number} repeats element {3 + first}; remove one")
    refused(flat, rf"tongue.ele: element {number} is flat")
    refused(
        outside, rf"element {number} names node {270 + first}, but the nodes are {first} to {269 + first}"
    )


def test_all_elements_inverted_are_turned_with_a_warning(wedge, write_tetgen):
    nodes, tets = wedge
    raw = read_tet_mesh(write_tetgen(nodes, tets[:, [1, 0, 2, 3]]))
    with pytest.warns(MeshWarning, match="they are turned"):
        mesh, _ = checked_mesh(raw, raw.nodes)
    assert mesh.volume == pytest.approx(TetMesh(nodes, tets).volume)


def test_flipped_bits_give_a_mesh_or_an_error_of_ours(wedge, write_tetgen):
    path = write_tetgen(*wedge)
    rng = np.random.default_rng(0)
    for suffix in (".node", ".ele"):
        file = path.with_suffix(suffix)
        content = file.read_bytes()
        for _ in range(100):
            damaged = bytearray(content)
            damaged[rng.integers(len(content))] ^= 1 << int(rng.integers(8))
            file.write_bytes(damaged)
            with warnings.catch_warnings():
                warnings.simplefilter("ignore", MeshWarning)
                try:
                    raw = read_tet_mesh(path)
                    mesh, _ = checked_mesh(raw, raw.nodes)
                except LingualError:
                    continue
            assert (mesh.volumes > 0).all()
        file.write_bytes(content)
