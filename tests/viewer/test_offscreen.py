"""The scene as pictures: what must be seen is looked for in the pixels."""

import numpy as np
import pytest
from synthetic_session import SyntheticSession

from lingual.model import LingualError
from lingual.viewer import context
from lingual.viewer.camera import VIEWS
from lingual.viewer.offscreen import OffscreenRenderer
from lingual.viewer.scene import default_camera
from lingual.viewer.sensor_layer import sensor_colour
from lingual.viewer.view_options import ViewOptions

PLAIN = ViewOptions(show_labels=False, show_targets=False)
NO_MOUTH = dict.fromkeys(("bone", "tooth", "mucosa"), False)


def difference(a, b):
    """Mean absolute difference of two pictures, 0 to 255."""
    return float(np.abs(a[..., :3].astype(int) - b[..., :3].astype(int)).mean())


def test_a_picture_shows_something_and_is_opaque(renderer):
    picture = renderer.render(0.0)
    assert picture.shape == (240, 320, 4)
    assert picture.dtype == np.uint8
    assert (picture[..., 3] == 255).all()
    assert picture[..., :3].std() > 15.0


def test_the_same_time_gives_the_same_picture_and_another_time_another(renderer):
    first = renderer.render(0.1).copy()
    later = renderer.render(0.55).copy()
    again = renderer.render(0.1).copy()
    assert difference(first, again) == 0.0
    assert difference(first, later) > 1.0


def test_views_differ(session, renderer):
    pictures = [renderer.render(0.0, camera=default_camera(session.model, view)).copy() for view in VIEWS]
    for i in range(len(pictures)):
        for j in range(i):
            assert difference(pictures[i], pictures[j]) > 2.0


def test_the_tongue_is_pink_in_its_natural_colours(renderer):
    options = ViewOptions(show_tissue=NO_MOUTH, show_sensors=False)
    red, green, blue = renderer.render(0.0, options=options)[100:140, 140:180, :3].reshape(-1, 3).mean(axis=0)
    assert red > green + 30
    assert red > blue + 30


@pytest.mark.parametrize("view", ["lateral", "three-quarter"])
def test_coils_are_drawn_where_the_camera_projects_them(session, renderer, view):
    options = ViewOptions(show_labels=False, show_targets=False, show_tissue=NO_MOUTH)
    camera = default_camera(session.model, view)
    camera.elevation += 0.3  # so that all of them are in sight
    picture = renderer.render(0.25, camera=camera, options=options)
    sample = session.history.sample(0.25)
    at = camera.project(sample.sensors + sample.jaw_translation, 320, 240)
    for i, (x, y, _) in enumerate(at):
        around = picture[round(y) - 1 : round(y) + 2, round(x) - 1 : round(x) + 2, :3]
        colour = around.reshape(-1, 3).mean(axis=0)
        wanted = 255.0 * np.array(sensor_colour(i))
        assert np.dot(colour, wanted) > 0.985 * np.linalg.norm(colour) * np.linalg.norm(wanted), (i, colour)


def test_targets_away_from_their_coils_are_shown(renderer):
    with_targets = renderer.render(0.0, options=ViewOptions(show_labels=False)).copy()
    assert difference(with_targets, renderer.render(0.0, options=PLAIN)) > 0.05


@pytest.mark.parametrize("name", ["displacement", "height change"])
def test_a_field_colours_the_tongue_and_has_a_bar(renderer, name):
    natural = renderer.render(0.3, options=PLAIN).copy()
    coloured = renderer.render(0.3, options=PLAIN, field=name).copy()
    assert difference(natural, coloured) > 2.0
    hues = [{tuple(c) for c in p[8:110, 250:316, :3].reshape(-1, 3) // 32} for p in (natural, coloured)]
    assert len(hues[1]) > len(hues[0]) + 5  # the bar in the corner steps through many


def test_the_cut_opens_the_tongue(session, renderer):
    camera = default_camera(session.model, "lateral")
    whole = renderer.render(0.0, camera=camera, options=PLAIN).copy()
    opened = ViewOptions(show_labels=False, show_targets=False, cut=True)
    cut = renderer.render(0.0, camera=camera, options=opened)
    assert difference(whole, cut) > 1.5


def test_names_and_caption_are_written(renderer):
    plain = renderer.render(0.0, options=PLAIN).copy()
    named = renderer.render(0.0, options=ViewOptions(show_targets=False, show_caption=True))
    changed = np.abs(named[..., :3].astype(int) - plain[..., :3]).sum(axis=-1) > 40
    assert changed[:200].sum() > 100
    assert changed[200:, :120].sum() > 40


def test_a_transparent_backdrop_leaves_alpha(renderer):
    alpha = renderer.render(0.0, options=ViewOptions(backdrop="transparent", show_labels=False))[..., 3]
    assert alpha[0, 0] == 0
    assert alpha[120, 160] == 255


def test_before_the_first_frame_the_tongue_is_at_rest(renderer, session):
    waiting = SyntheticSession(simulated=-1.0)
    assert waiting.history.frame_count == 0
    with OffscreenRenderer(waiting, 64, 48) as early:
        assert early.render(0.5, field="displacement")[..., :3].std() > 5.0


def test_two_renderers_at_once_do_not_mix(session, renderer):
    before = renderer.render(0.2).copy()
    with OffscreenRenderer(session, 101, 67, samples=0) as other:
        assert other.render(0.2).shape == (67, 101, 4)
        assert difference(renderer.render(0.2), before) == 0.0
    assert difference(renderer.render(0.2), before) == 0.0


def test_an_impossible_size_is_refused(session, gl):
    with pytest.raises(LingualError, match="0 x 10"):
        OffscreenRenderer(session, 0, 10, context=gl)


def test_a_machine_without_egl_is_told_what_to_install(session, monkeypatch):
    def missing(**arguments):
        raise Exception("libEGL.so.1 not loaded")

    monkeypatch.setattr(context.moderngl, "create_context", missing)
    with pytest.raises(LingualError, match="apt-get install libegl1 libgl1-mesa-dri"):
        OffscreenRenderer(session, 64, 48)


def test_an_old_driver_is_named(session, monkeypatch):
    def refused(**arguments):
        raise Exception("eglCreateContext failed (0x3009)")

    monkeypatch.setattr(context.moderngl, "create_context", refused)
    with pytest.raises(LingualError, match=r"OpenGL 4\.1"):
        OffscreenRenderer(session, 64, 48)
