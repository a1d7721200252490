import numpy as np

from lingual.viewer.labels import label_corners

SIZE = np.array([30.0, 20.0])


def test_a_label_is_right_of_and_above_its_point():
    corner = label_corners(np.array([[100.0, 200.0]]), SIZE[None], 10.0)
    np.testing.assert_allclose(corner, [[110.0, 170.0]])


def test_labels_of_points_on_top_of_each_other_do_not_overlap():
    points = np.array([[100.0, 200.0], [101.0, 199.0], [99.0, 203.0], [300.0, 200.0], [np.nan, np.nan]])
    corners = label_corners(points, np.tile(SIZE, (5, 1)), 10.0)
    assert np.isnan(corners[4]).all()
    for i in range(4):
        for j in range(i):
            assert np.any(np.abs(corners[i] - corners[j]) >= SIZE)
