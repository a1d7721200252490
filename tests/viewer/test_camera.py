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


LOW, HIGH = np.array([-0.06, -0.03, -0.04]), np.array([0.01, 0.03, 0.03])
BOX = np.array(list(itertools.product(*zip(LOW, HIGH, strict=True))))


@pytest.mark.parametrize("view", VIEWS)
@pytest.mark.parametrize("orthographic", [False, True])
@pytest.mark.parametrize(("width", "height"), [(720, 720), (960, 720)])
def test_what_is_framed_is_wholly_seen(view, orthographic, width, height):
    camera = framing(BOX, view, width / height)
    camera.orthographic = orthographic
    at = camera.project(BOX, width, height)
    assert np.all((at[:, 0] > 0) & (at[:, 0] < width))
    assert np.all((at[:, 1] > 0) & (at[:, 1] < height))
    assert np.all(np.abs(at[:, 2]) < 1.0)


@pytest.mark.parametrize("view", VIEWS)
def test_framing_fills_the_picture(view):
    """The box reaches nearly to two opposite edges and stands in the middle."""
    at = framing(BOX, view).project(BOX, 720, 720)[:, :2]
    assert np.ptp(at, axis=0).max() > 0.80 * 720
    assert np.abs(0.5 * (at.min(axis=0) + at.max(axis=0)) - 360.0).max() < 0.1 * 720


def test_another_view_frames_the_subject_anew():
    camera = framing(BOX, "three-quarter")
    camera.look("top")
    other = framing(BOX, "top")
    assert camera.distance == pytest.approx(other.distance)
    assert camera.target == pytest.approx(other.target)
    free = Camera(distance=0.4)
    free.look("top")
    assert free.distance == 0.4


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
