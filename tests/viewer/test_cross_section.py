import numpy as np
from synthetic_session import ball_mesh

from lingual.viewer.cross_section import cross_section


def test_the_section_of_an_ellipsoid_is_an_ellipse_in_the_plane():
    mesh = ball_mesh(10)
    height = mesh.nodes[:, 1] - 0.0013
    nodes, weight = cross_section(mesh.tets, height)
    corners = (1.0 - weight)[:, None] * mesh.nodes[nodes[:, 0]] + weight[:, None] * mesh.nodes[nodes[:, 1]]
    np.testing.assert_allclose(corners[:, 1], 0.0013, atol=1e-8)
    a, b, c = corners.reshape(-1, 3, 3).transpose(1, 0, 2)
    area = 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1).sum()
    np.testing.assert_allclose(area, np.pi * 0.030 * 0.014, rtol=0.06)


def test_the_four_cases_of_one_tetrahedron():
    tet = np.array([[0, 1, 2, 3]])
    assert len(cross_section(tet, np.array([-1.0, 1.0, 1.0, 1.0]))[0]) == 3
    assert len(cross_section(tet, np.array([-1.0, -1.0, 1.0, 1.0]))[0]) == 6
    assert len(cross_section(tet, np.array([1.0, 1.0, 1.0, 1.0]))[0]) == 0
    assert len(cross_section(tet, np.array([-1.0, -1.0, -1.0, 0.0]))[0]) == 0
