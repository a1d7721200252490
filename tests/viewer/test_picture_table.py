"""Stills side by side, and categories that keep their colours apart."""

import numpy as np
import pytest
from synthetic_session import synthetic_model

from lingual.model import LingualError
from lingual.viewer.colour_bar import listed
from lingual.viewer.colour_map import colour_table
from lingual.viewer.offscreen import OffscreenRenderer
from lingual.viewer.overlay import colour_bar_sprite
from lingual.viewer.picture_table import picture_table, write_picture_table
from lingual.viewer.session_view import ScalarField
from lingual.viewer.stills import PictureRow, Still, StillSession
from lingual.viewer.view_options import ViewOptions

CELL = (160, 120)
LINE = round(0.13 * 120)
ROW_HEIGHT = CELL[1] + 2 * LINE


@pytest.fixture(scope="module")
def model():
    return synthetic_model()


@pytest.fixture(scope="module")
def halves(model):
    """Front and rear half of the ellipsoid as two categories."""
    front = (model.mesh.nodes[:, 0] > -0.035).astype(float)
    return ScalarField("half", front, "", (0.0, 1.0), categories=("rear", "front"))


@pytest.fixture(scope="module")
def rows(model, halves):
    rest = model.mesh.nodes
    height = ScalarField("height", 1e3 * rest[:, 2], "mm", (-22.0, 6.0))
    lifted = rest + np.array([0.0, 0.0, 0.012])
    return [
        PictureRow("first", model, (Still("rest", rest), Still("height", rest, height), Still("lifted", lifted))),
        PictureRow("second", model, (Still("halves", rest, halves),), "three-quarter"),
    ]


@pytest.fixture(scope="module")
def table(rows):
    try:
        return picture_table(rows, CELL)
    except LingualError as error:
        pytest.skip(f"no EGL with OpenGL 4.1: {error}")


def test_a_session_of_stills_shows_each_at_its_second(rows):
    session = StillSession(rows[0].model, rows[0].stills)
    assert session.field_names() == ("none", "1")
    assert [session.field_name(k) for k in range(3)] == ["none", "1", "none"]
    for k, still in enumerate(rows[0].stills):
        np.testing.assert_allclose(session.history.sample(float(k)).nodes, still.nodes, atol=1e-7)
    assert session.field("1", session.history.sample(1.0)) is rows[0].stills[1].scalar


def test_rows_are_below_each_other_and_equally_wide(table):
    assert table.shape == (2 * ROW_HEIGHT, 3 * CELL[0] + round(0.36 * CELL[0]), 4)
    assert (table[..., 3] == 255).all()


def middle_of(table, row, column):
    """The inner part of a cell, RGB."""
    top = row * ROW_HEIGHT + LINE
    return table[top + 20 : top + 95, column * CELL[0] + 20 : column * CELL[0] + 140, :3].astype(int)


def test_every_cell_shows_its_still(table):
    rest, height, lifted = (middle_of(table, 0, k) for k in range(3))
    assert min(cell.std() for cell in (rest, height, lifted)) > 15.0
    assert np.abs(rest - height).mean() > 10.0  # other colours
    assert np.abs(rest - lifted).mean() > 5.0  # another place: one camera for the row

    def centre(cell):
        pink = cell[..., 0] > cell[..., 1] + 40
        return np.nonzero(pink)[0].mean()

    assert centre(lifted) < centre(rest) - 5


def test_the_bars_stand_at_the_end_of_their_row(table):
    bars = table[:, 3 * CELL[0] :, :3].astype(int)
    assert bars[:120].std() > 5.0


def test_a_table_is_written_into_a_new_folder(rows, table, tmp_path):
    path = write_picture_table(tmp_path / "new" / "table.png", rows[1:], CELL)
    assert path.stat().st_size > 1000


@pytest.mark.parametrize("cut", [False, True])
def test_categories_do_not_mix(model, halves, cut):
    """Two categories far apart on the colour map: nothing between them is seen where they meet."""
    names = ("rear", "unused", "between", "front")
    far = ScalarField("half", 3.0 * halves.values, "", (0.0, 3.0), categories=names)
    session = StillSession(model, (Still("halves", model.mesh.nodes, far),))
    plain = ViewOptions(show_tissue=dict.fromkeys(("bone", "tooth", "mucosa"), False), show_sensors=False, cut=cut)
    plain.show_colour_bar = False
    try:
        with OffscreenRenderer(session, 240, 180) as renderer:
            picture = renderer.render(0.0, field="0", options=plain)[..., :3].astype(float)
    except LingualError as error:
        pytest.skip(f"no EGL with OpenGL 4.1: {error}")
    rear, _, between, front = colour_table("categories")[:4].astype(float)

    def like(colour):
        """Pixels of the colour's hue, however bright."""
        direction = (colour - colour.mean()) / np.linalg.norm(colour - colour.mean())
        pixel = picture - picture.mean(axis=2, keepdims=True)
        length = np.linalg.norm(pixel, axis=2)
        return ((pixel @ direction > 0.95 * length) & (length > 15.0)).sum()

    assert like(rear) > 200
    assert like(front) > 200
    assert like(between) < 0.01 * (like(rear) + like(front))


def test_colours_of_categories_are_distinct():
    colours = colour_table("categories")[:40].astype(int)
    gaps = np.abs(colours[:, None] - colours[None]).max(axis=2)
    assert gaps[np.triu_indices(40, 1)].min() > 8
    first = gaps[:5, :5][np.triu_indices(5, 1)]
    assert first.min() > 40


def test_a_category_lies_at_its_own_colour(halves):
    place = halves.fraction()
    np.testing.assert_allclose(np.unique(place) * 255.0, [0.0, 1.0], atol=1e-5)
    assert halves.map_name == "categories"


def test_names_beyond_the_room_are_counted():
    assert listed(("a", "b", "c"), 3) == ["a", "b", "c"]
    assert listed(("a", "b", "c", "d"), 3) == ["a", "b", "and 2 more"]


def test_the_legend_of_categories_has_a_swatch_for_each(halves):
    sprite = colour_bar_sprite(halves, 360, (38, 44, 54))
    pixels = sprite[..., :3].reshape(-1, 3)
    for colour in colour_table("categories")[:2]:
        assert (np.abs(pixels.astype(int) - colour).max(axis=1) <= 2).sum() > 20
