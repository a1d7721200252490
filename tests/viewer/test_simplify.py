import numpy as np
from synthetic_session import ball_mesh

from lingual.viewer.simplify import simplified


def surface(cells):
    mesh = ball_mesh(cells)
    return mesh.nodes, mesh.boundary_triangles


def volume(vertices, triangles):
    a, b, c = (vertices[triangles[:, k]] for k in range(3))
    return np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0


def test_fewer_triangles_enclose_nearly_the_same_volume():
    vertices, triangles = surface(12)
    kept, fewer = simplified(vertices, triangles, len(triangles) // 3)
    assert len(fewer) <= 1.3 * len(triangles) / 3
    np.testing.assert_allclose(volume(vertices[kept], fewer), volume(vertices, triangles), rtol=0.05)


def test_a_closed_surface_stays_closed_and_oriented():
    vertices, triangles = surface(10)
    _, fewer = simplified(vertices, triangles, len(triangles) // 2)
    directed = fewer[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    forward = {tuple(edge) for edge in directed}
    assert len(forward) == len(directed)
    assert all((b, a) in forward for a, b in forward)


def test_small_surfaces_are_left_alone():
    vertices, triangles = surface(4)
    kept, same = simplified(vertices, triangles, 10_000)
    assert len(same) == len(triangles)
    np.testing.assert_allclose(vertices[kept][same], vertices[triangles])


def test_an_open_border_does_not_move():
    x, y = np.meshgrid(np.arange(12.0), np.arange(12.0), indexing="ij")
    vertices = np.stack([x.ravel(), y.ravel(), np.zeros(144)], axis=1)
    corner = (np.arange(11)[:, None] * 12 + np.arange(11)).ravel()
    triangles = np.concatenate(
        [np.stack([corner, corner + 12, corner + 13], 1), np.stack([corner, corner + 13, corner + 1], 1)]
    )
    kept, fewer = simplified(vertices, triangles, 60)
    assert len(fewer) < 150
    border = np.flatnonzero((x.ravel() % 11 == 0) | (y.ravel() % 11 == 0))
    assert np.isin(border, kept).all()
    a, b, c = (vertices[kept][fewer[:, k]] for k in range(3))
    np.testing.assert_allclose(0.5 * np.cross(b - a, c - a)[:, 2].sum(), 121.0)
