import itertools

import numpy as np
import pytest

from lingual.viewer.camera import VIEWS, Camera, framing


def test_the_target_is_in_the_middle_of_the_picture():
    camera = Camera(target=np.array([0.01, -0.02, 0.03]))
    x, y, depth = camera.project(camera.target[None], 640, 480)[0]
    assert (x, y) == pytest.approx((320, 240))
    assert -1.0 < depth < 1.0


def test_the_lateral_view_has_the_tip_left_and_the_palate_above():
    camera = Camera()
    camera.look("lateral")
    front, above = camera.project(np.array([[0.03, 0.0, 0.0], [0.0, 0.0, 0.03]]), 640, 480)
    assert front[0] < 320
    assert above[1] < 240
    assert above[0] == pytest.approx(320)


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("orthographic", [False, True])
def test_a_framed_box_is_wholly_seen(view, orthographic):
    low, high = np.array([-0.06, -0.03, -0.04]), np.array([0.01, 0.03, 0.03])
    camera = framing(low, high, view)
    camera.orthographic = orthographic
    corners = np.array(list(itertools.product(*zip(low, high, strict=True))))
    at = camera.project(corners, 720, 720)
    assert np.all((at[:, :2] > 0) & (at[:, :2] < 720))
    assert np.all(np.abs(at[:, 2]) < 1.0)


def test_dragging_right_moves_what_is_in_front_to_the_right():
    camera = Camera()
    near = camera.target + 0.02 * camera.direction()
    camera.orbit(0.1, 0.0)
    assert camera.project(near[None], 640, 480)[0, 0] > 320
    camera = Camera()
    camera.orbit(0.0, 0.1)
    assert camera.project(near[None], 640, 480)[0, 1] < 240


def test_panning_moves_the_picture_by_the_fraction_asked_for():
    camera, before = Camera(), Camera().target
    camera.pan(0.25, 0.1)
    x, y, _ = camera.project(before[None], 640, 480)[0]
    assert (x, y) == pytest.approx((320 + 120, 240 - 48), abs=0.5)


def test_zoom_and_elevation_stay_within_limits():
    camera = Camera()
    camera.zoom(1000)
    assert camera.distance > 0.0
    camera.zoom(-1000)
    assert np.isfinite(camera.distance)
    camera.orbit(0.0, -10.0)
    assert np.isfinite(camera.view_projection(1.0)).all()
