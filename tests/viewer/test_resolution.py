"""Fewer pixels when the processor that draws falls behind, and back."""

import numpy as np

from lingual.viewer.resolution import SCALES, AdaptiveScale, ScaledPicture

PERIOD = 1.0 / 60.0


def after(scale: AdaptiveScale, work: float, pictures: int) -> float:
    for _ in range(pictures):
        scale.add(work)
    return scale.scale


def test_slow_pictures_lower_the_scale_step_by_step_and_no_further_than_the_last():
    scale = AdaptiveScale(PERIOD)
    assert after(scale, 2.0 * PERIOD, 24) == SCALES[1]
    assert after(scale, 2.0 * PERIOD, 24 * len(SCALES)) == SCALES[-1]


def test_fast_pictures_raise_it_again_and_those_in_between_leave_it():
    scale = AdaptiveScale(PERIOD)
    after(scale, 2.0 * PERIOD, 48)
    assert after(scale, 0.5 * PERIOD, 240) == SCALES[2]
    assert after(scale, 0.1 * PERIOD, 48) == SCALES[0]


def test_a_single_slow_picture_changes_nothing():
    scale = AdaptiveScale(PERIOD)
    scale.add(1.0)
    assert after(scale, 0.5 * PERIOD, 23) == SCALES[0]


def test_a_small_picture_fills_the_viewport_it_is_shown_in(gl):
    picture, screen = ScaledPicture(gl), gl.simple_framebuffer((64, 48), 4)
    picture.begin(16, 12)
    gl.clear(0.2, 0.4, 0.6, 1.0)
    screen.use()
    screen.clear(0.0, 0.0, 0.0, 0.0)
    picture.show()
    pixels = np.frombuffer(screen.read(components=4), dtype=np.uint8).reshape(-1, 4)
    np.testing.assert_array_equal(pixels, np.tile([51, 102, 153, 255], (len(pixels), 1)))
    picture.release()
    assert gl.error == "GL_NO_ERROR"
