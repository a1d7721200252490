"""Surfaces to tetrahedra: node count, orientation, and one clear sentence for what cannot be filled."""

import numpy as np
import pytest

from lingual.model import LingualError
from lingual.precompute.surfacing import surface_of
from lingual.precompute.tetrahedralise import closed_surface, enclosed_volume, tetrahedralise


def ellipsoid():
    return surface_of(
        lambda p: 10.0 * (np.linalg.norm(p / [1.5, 1.0, 0.8], axis=1) / 10.0 - 1.0),
        (-17.0, -12.0, -10.0),
        (17.0, 12.0, 10.0),
        1.5,
    )


@pytest.mark.parametrize("node_count", [400, 900])
def test_node_count_and_volume(node_count, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    vertices, triangles = ellipsoid()
    mesh = tetrahedralise(vertices * 1e-3, triangles, node_count)
    assert mesh.node_count == pytest.approx(node_count, rel=0.15)
    assert mesh.volume == pytest.approx(enclosed_volume(vertices, triangles) * 1e-9, rel=0.03)
    assert (mesh.volumes > 0.0).all()
    assert len(np.unique(mesh.tets)) == mesh.node_count
    assert not any(tmp_path.iterdir()), "fTetWild's scratch file stays out of the user's folder"


def test_orientation_and_repeated_vertices_are_mended():
    vertices, triangles = ellipsoid()
    soup = vertices[triangles].reshape(-1, 3)  # as an STL file has it
    faces = np.arange(len(soup)).reshape(-1, 3)
    rng = np.random.default_rng(0)
    flipped = rng.random(len(faces)) < 0.4
    faces[flipped] = faces[flipped][:, ::-1]
    points, mended = closed_surface(soup, faces)
    assert len(points) == len(vertices)
    assert enclosed_volume(points, mended) == pytest.approx(enclosed_volume(vertices, triangles), rel=1e-6)


@pytest.mark.parametrize(
    ("break_it", "message"),
    [
        (lambda v, t: (v, t[1:]), "chin is not closed: 3 of its edges"),
        (lambda v, t: (v[:0], t[:0]), "chin has no closed triangle surface"),
        (lambda v, t: (np.where(np.arange(len(v))[:, None] == 5, np.nan, v), t), "chin has a vertex whose"),
        (lambda v, t: (v * [1.0, 1.0, 0.0], t), "chin"),
    ],
    ids=["open", "empty", "nan", "flat"],
)
def test_what_cannot_be_filled_is_named(break_it, message):
    with pytest.raises(LingualError, match=message):
        tetrahedralise(*break_it(*ellipsoid()), 300, name="chin")
